// Sixteen LOD units side by side, for the sweep of all ratios: one evaluation answers sixteen
// inputs, and what is not looked at is not computed.
module lod_sweep #(
  parameter int Log2 = tex_pkg::Log2
) (
  // The upper 28 bits of the ratio.
  input  logic [27:0]  high_i,
  output logic [255:0] raw_o
);
  for (genvar low = 0; low < 16; low++) begin : gen_low
    lod #(.Log2(Log2)) u_lod (
      .scale_i({high_i, 4'(low)}), .explicit_i(1'b0), .bias_i('0), .min_lod_i('0), .max_lod_i('0), .last_i('0),
      .level_rounding_i('0), .raw_o(raw_o[16*low +: 16]), .clamped_o(), .fractional_o(), .whole_o()
    );
  end
endmodule : lod_sweep
