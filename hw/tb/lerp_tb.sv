// lerp.sv against its trace.
module tb;
  parameter int Rounding = tex_pkg::Rounding;
  localparam int Width = 3 * 8 + 16;
  localparam int OutputWidth = Rounding == tex_pkg::RoundOnce ? 16 : 8;
  `include "trace.svh"
  logic [7:0]  a, b, fraction;
  logic [15:0] wanted;
  wire  [OutputWidth-1:0] value;
  lerp #(.Rounding(Rounding)) u_lerp (.a_i(a), .b_i(b), .fraction_i(fraction), .value_o(value));
  initial begin
    load;
    for (at = 0; at < Count; at = at + 1) begin
      {a, b, fraction, wanted} = trace[at];
      #1 expect_value(wanted, value, "value");
    end
    $display("PASS lerp %0d vectors", Count);
    $finish;
  end
endmodule
