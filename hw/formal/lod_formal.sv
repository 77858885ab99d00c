// What lod.sv promises for all inputs; combinational, so one SAT call proves it for good.
module lod_formal #(
  parameter int Log2 = 0,
  parameter int LodBits = 8
) (
  input logic [31:0]        scale_i,
  input logic [31:0]        other_i,
  input logic               explicit_i,
  input logic signed [13:0] bias_i,
  input logic [13:0]        min_lod_i,
  input logic [13:0]        max_lod_i,
  input logic [3:0]         last_i,
  input logic [1:0]         level_rounding_i
);
  wire signed [15:0] raw, other_raw;
  wire [11:0] clamped, other_clamped, fractional, other_fractional;
  wire [3:0]  whole, other_whole;
  lod #(.Log2(Log2), .LodBits(LodBits)) u_lod (
    .scale_i, .explicit_i, .bias_i, .min_lod_i, .max_lod_i, .last_i, .level_rounding_i,
    .raw_o(raw), .clamped_o(clamped), .fractional_o(fractional), .whole_o(whole)
  );
  lod #(.Log2(Log2), .LodBits(LodBits)) u_other (
    .scale_i(other_i), .explicit_i, .bias_i, .min_lod_i, .max_lod_i, .last_i, .level_rounding_i,
    .raw_o(other_raw), .clamped_o(other_clamped), .fractional_o(other_fractional), .whole_o(other_whole)
  );

  // The formula of docs/numerics.md, section 4.1, as a count of steps.
  `include "log2_steps.svh"
  wire [7:0]  exponent = scale_i[30:23];
  wire [22:0] mantissa = scale_i[22:0];
  wire signed [15:0] octaves = $signed({8'd0, exponent}) - 16'sd127;
  wire signed [15:0] formula =
      exponent == 8'hff ? 16'sd16384
      : exponent == 8'h00 ? -16'sd16256
      : Log2 == 1 ? $signed({1'b0, scale_i[30:16]}) - 16'sd16256
      : Log2 == 2 ? (octaves - $signed({15'd0, octaves[0]})) * 16'sd128
      : octaves * 16'sd128 + $signed({8'd0, steps(mantissa)});
  wire not_above = explicit_i ? $signed(scale_i) <= $signed(other_i) : scale_i[30:0] <= other_i[30:0];

  always_comb begin
    // The formula, for every ratio.
    assert (raw == formula);
    // Never beyond the chain, nor above the largest level.
    assert (clamped <= {last_i, 8'd0} && fractional <= {last_i, 8'd0} && whole <= last_i);
    assert ({2'd0, clamped} <= max_lod_i);
    // No fraction at the end of the chain (E8).
    assert (fractional[11:8] != last_i || fractional[7:0] == 8'd0);
    // A larger ratio never selects a sharper level.
    if (not_above) begin
      assert (explicit_i || raw <= other_raw);
      assert (clamped <= other_clamped && fractional <= other_fractional && whole <= other_whole);
    end
  end
endmodule : lod_formal
