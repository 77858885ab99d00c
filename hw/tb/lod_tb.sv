// lod.sv against its trace.
module tb;
  parameter int Log2 = tex_pkg::Log2;
  parameter int LodBits = tex_pkg::LodBits;
  localparam int Width = 32 + 4 + 3 * 16 + 4 + 4 + 3 * 16 + 4;
  `include "trace.svh"
  logic [31:0] scale;
  logic [3:0]  explicit_level, last, level_rounding, wanted_whole;
  logic [15:0] bias, min_lod, max_lod, wanted_raw, wanted_clamped, wanted_fractional;
  wire  [15:0] raw;
  wire  [11:0] clamped, fractional;
  wire  [3:0]  whole;
  lod #(.Log2(Log2), .LodBits(LodBits)) u_lod (
    .scale_i(scale), .explicit_i(explicit_level[0]), .bias_i(bias[13:0]), .min_lod_i(min_lod[13:0]),
    .max_lod_i(max_lod[13:0]), .last_i(last), .level_rounding_i(level_rounding[1:0]), .raw_o(raw),
    .clamped_o(clamped), .fractional_o(fractional), .whole_o(whole)
  );
  initial begin
    load;
    for (at = 0; at < Count; at = at + 1) begin
      {scale, explicit_level, bias, min_lod, max_lod, last, level_rounding,
       wanted_raw, wanted_clamped, wanted_fractional, wanted_whole} = trace[at];
      #1;
      expect_value(wanted_raw, raw, "raw");
      expect_value(wanted_clamped, clamped, "clamped");
      expect_value(wanted_fractional, fractional, "fractional");
      expect_value(wanted_whole, whole, "whole");
    end
    $display("PASS lod %0d vectors", Count);
    $finish;
  end
endmodule
