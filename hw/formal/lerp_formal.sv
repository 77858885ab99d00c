// A lerp stays between its ends, whichever is larger (so a flat colour passes unchanged), exact and rounded.
// Combinational: one SAT call a property, one property at a time, because a solver is much faster so.
module lerp_formal #(
  parameter int Width = 8,
  parameter int FractionBits = 8,
  parameter int Rounding = 0,
  // 1, 2: not below, not above where a <= b; 3, 4: where a >= b.
  parameter int Property = 1
) (
  input logic [Width-1:0]        a_i,
  input logic [Width-1:0]        b_i,
  input logic [FractionBits-1:0] fraction_i
);
  localparam int Extra = Rounding == 0 ? FractionBits : 0;
  wire [Width+Extra-1:0] value;
  lerp #(.Width(Width), .FractionBits(FractionBits), .Rounding(Rounding)) u_lerp (
    .a_i, .b_i, .fraction_i, .value_o(value)
  );
  wire [Width+Extra-1:0] a = (Width + Extra)'(a_i) << Extra;
  wire [Width+Extra-1:0] b = (Width + Extra)'(b_i) << Extra;
  if (Property == 1) begin : gen_rising_low
    always_comb assert (a_i > b_i || value >= a);
  end else if (Property == 2) begin : gen_rising_high
    always_comb assert (a_i > b_i || value <= b);
  end else if (Property == 3) begin : gen_falling_low
    always_comb assert (a_i < b_i || value >= b);
  end else begin : gen_falling_high
    always_comb assert (a_i < b_i || value <= a);
  end
endmodule : lerp_formal
