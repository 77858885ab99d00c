// One axis of a tap: from a 12.20 coordinate to the index of one texel and the bilinear fraction
// (docs/numerics.md, section 3), for power-of-two sizes. Combinational.
//
// Scaling is a shift; the fraction is cut from the same register as the index, so the two can never
// disagree at a texel border. The address mode is applied to each texel on its own (D3D's rule).
module coordinate #(
  // Bits of the bilinear fraction, 1 to 12.
  parameter int FilterBits = tex_pkg::FilterBits
) (
  // 12.20, two's complement: one repeat of the texture is 1.0.
  input  logic [31:0]                     coordinate_i,
  // log2 of the plane's size on this axis, at most MaxLog2Side.
  input  logic [tex_pkg::LevelBits-1:0]   log2_size_i,
  input  logic [1:0]                      mode_i,
  // A point tap: the texel under the coordinate, no half texel.
  input  logic                            point_i,
  // The second texel of the pair.
  input  logic                            upper_i,
  output logic [tex_pkg::MaxLog2Side-1:0] index_o,
  // Clip only: nothing is read, the texel is transparent black.
  output logic                            outside_o,
  output logic [FilterBits-1:0]           fraction_o
);
  localparam int Side  = tex_pkg::MaxLog2Side;
  // Bits of a scaled coordinate less half a texel.
  localparam int Wide  = 32 + Side + 1;
  localparam int Whole = Wide - tex_pkg::CoordinateBits + 1;

  // One period, or everything.
  logic signed [Wide-1:0] reduced;
  always_comb begin
    case (mode_i)
      tex_pkg::AddressWrap:   reduced = {(Wide - 20)'(0), coordinate_i[19:0]};
      tex_pkg::AddressMirror: reduced = {(Wide - 21)'(0), coordinate_i[20:0]};
      default:                reduced = {{(Wide - 32){coordinate_i[31]}}, coordinate_i};
    endcase
  end

  logic signed [Wide-1:0] position;
  assign position = (reduced <<< log2_size_i) - (point_i ? Wide'(0) : Wide'(1 << 19));

  logic signed [Whole-1:0] index;
  assign index = $signed({position[Wide-1], position[Wide-1:20]}) + $signed({(Whole - 1)'(0), upper_i});
  assign fraction_o = point_i ? '0 : position[19-:FilterBits];
  if (FilterBits < 20) begin : gen_unused
    logic [19-FilterBits:0] unused_position;
    assign unused_position = position[19-FilterBits:0];
  end

  logic [Side-1:0] mask;
  logic            negative, beyond, odd_period;
  assign mask       = ~({Side{1'b1}} << log2_size_i);
  assign negative   = index[Whole-1];
  assign beyond     = !negative && |(index & ~$signed({(Whole - Side)'(0), mask}));
  // The bit above the index tells the mirrored periods from the others.
  assign odd_period = |(index[Side:0] & ({1'b0, mask} + {Side'(0), 1'b1}));

  always_comb begin
    case (mode_i)
      tex_pkg::AddressWrap:   index_o = index[Side-1:0] & mask;
      tex_pkg::AddressMirror: index_o = (odd_period ? ~index[Side-1:0] : index[Side-1:0]) & mask;
      // Clip needs no index where it is outside; clamp's does no harm there.
      default:                index_o = negative ? '0 : beyond ? mask : index[Side-1:0];
    endcase
  end
  assign outside_o = mode_i == tex_pkg::AddressClip && (negative || beyond);
endmodule : coordinate
