// The LOD unit: from the bits of a squared scaling ratio, or an 8.8 level, to the level a filter
// works on (docs/numerics.md, section 4). Combinational.
//
// The exponent field of the float is the integer part of the logarithm (Herf 1999, part 4), so the
// unit is a table, a comparator and two clamps: no multiplier.
module lod #(
  // Rung of the log2 unit: Log2Exact, Log2Herf or Log2Ilog2.
  parameter int Log2 = tex_pkg::Log2,
  // Bits of the level fraction, 0 to 8.
  parameter int LodBits = tex_pkg::LodBits
) (
  // Bits of an f32, or a sign-extended 8.8 level if explicit_i.
  input  logic        [31:0]                    scale_i,
  input  logic                                  explicit_i,
  // 8.8, within +-16.0.
  input  logic signed [13:0]                    bias_i,
  // 8.8, 0 to 32.0.
  input  logic        [13:0]                    min_lod_i,
  input  logic        [13:0]                    max_lod_i,
  // The last level of the chain.
  input  logic        [tex_pkg::LevelBits-1:0]  last_i,
  input  logic        [1:0]                     level_rounding_i,
  // The level of the ratio before bias and clamp, 8.8 (whatever explicit_i says).
  output logic signed [15:0]                    raw_o,
  // After bias and clamp; what is left of the fraction; one whole level. 8.8, 8.8, integer.
  output logic        [tex_pkg::LevelBits+7:0]  clamped_o,
  output logic        [tex_pkg::LevelBits+7:0]  fractional_o,
  output logic        [tex_pkg::LevelBits-1:0]  whole_o
);
  localparam int Wide = tex_pkg::LevelBits + 8;

  logic [7:0]  exponent;
  logic [22:0] mantissa;
  assign exponent = scale_i[30:23];
  assign mantissa = scale_i[22:0];

  logic signed [15:0] octaves, ratio_level;
  assign octaves = $signed({8'd0, exponent}) - 16'sd127;

  if (Log2 == tex_pkg::Log2Exact) begin : gen_exact
    logic [7:0]  level;
    logic [23:0] boundary;
    log2_table u_log2_table (.index_i(mantissa[22:15]), .level_o(level), .boundary_o(boundary));
    assign ratio_level =
        (octaves <<< 7) + $signed({8'd0, level}) + $signed({15'd0, {1'b0, mantissa} >= boundary});
  end else if (Log2 == tex_pkg::Log2Herf) begin : gen_herf
    assign ratio_level = (octaves <<< 7) + $signed({9'd0, mantissa[22:16]});
    logic [15:0] unused_mantissa;
    assign unused_mantissa = mantissa[15:0];
  end else begin : gen_ilog2
    assign ratio_level = (octaves >>> 1) <<< 8;
    logic [22:0] unused_mantissa;
    assign unused_mantissa = mantissa;
  end

  // Infinity and NaN are the coarsest level, zero and denormals the finest (X16).
  assign raw_o = exponent == 8'hff ? 16'sd16384 : exponent == 8'h00 ? -16'sd16256 : ratio_level;

  // Two bits wider than an explicit level: the sum needs no saturation.
  logic signed [33:0] level_sum;
  assign level_sum = (explicit_i ? $signed({{2{scale_i[31]}}, scale_i}) : $signed({{18{raw_o[15]}}, raw_o}))
                   + $signed({{20{bias_i[13]}}, bias_i});

  // Clamp before the split (E8): the upper bound wins where the two cross.
  logic [Wide-1:0] chain_end, high;
  logic            below_low;
  logic [33:0]     above_low;
  assign chain_end = {last_i, 8'd0};
  assign high      = max_lod_i < 14'(chain_end) ? max_lod_i[Wide-1:0] : chain_end;
  assign below_low = level_sum < $signed({20'd0, min_lod_i});
  assign above_low = below_low ? {20'd0, min_lod_i} : level_sum;
  assign clamped_o = above_low > 34'(high) ? high : above_low[Wide-1:0];

  // Keep LodBits of the fraction, half up. It cannot pass the end of the chain, a whole level.
  if (LodBits == 8) begin : gen_full_fraction
    assign fractional_o = clamped_o;
  end else begin : gen_short_fraction
    localparam int Dropped = 8 - LodBits;
    logic [Wide-1:0] rounded;
    assign rounded      = clamped_o + Wide'(1 << (Dropped - 1));
    assign fractional_o = {rounded[Wide-1:Dropped], Dropped'(0)};
    logic [Dropped-1:0] unused_rounded;
    assign unused_rounded = rounded[Dropped-1:0];
  end

  logic [7:0]                  added;
  logic [Wide:0]               whole_sum;
  logic [tex_pkg::LevelBits:0] whole;
  assign added     = level_rounding_i == tex_pkg::LevelFloor ? 8'd0
                   : level_rounding_i == tex_pkg::LevelGl ? 8'd127 : 8'd128;
  assign whole_sum = {1'b0, clamped_o} + {5'd0, added};
  assign whole     = whole_sum[Wide:8];
  assign whole_o   = whole > {1'b0, last_i} ? last_i : whole[tex_pkg::LevelBits-1:0];
  logic [7:0] unused_whole_sum;
  assign unused_whole_sum = whole_sum[7:0];
endmodule : lod
