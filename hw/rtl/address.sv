// The address unit: from a tap's coordinate and plane to the byte address of one of its texels
// (docs/numerics.md, section 3; docs/layouts.md), row-major or tiled. Combinational.
//
// Both layouts are separable and all sizes powers of two, so an offset is wiring and shifts; the
// parts never overlap and the one adder is that of the plane's base.
module address #(
  // Bits of the bilinear fraction, 1 to 12.
  parameter int FilterBits     = tex_pkg::FilterBits,
  // log2 of width and height of a tile in texels, at least 1 each.
  parameter int TileLog2Width  = tex_pkg::TileLog2Width,
  parameter int TileLog2Height = tex_pkg::TileLog2Height
) (
  // 12.20, two's complement.
  input  logic [31:0]                     u_i,
  input  logic [31:0]                     v_i,
  // The plane: byte address of texel (0, 0), log2 of width and height.
  input  logic [tex_pkg::AddressBits-1:0] base_i,
  input  logic [tex_pkg::LevelBits-1:0]   log2_width_i,
  input  logic [tex_pkg::LevelBits-1:0]   log2_height_i,
  input  logic [1:0]                      mode_u_i,
  input  logic [1:0]                      mode_v_i,
  input  logic                            tiled_i,
  input  logic                            point_i,
  // Which texel of the tap: bit 0 the right, bit 1 the lower.
  input  logic [1:0]                      corner_i,
  output logic [tex_pkg::AddressBits-1:0] address_o,
  output logic                            outside_o,
  output logic [FilterBits-1:0]           fraction_u_o,
  output logic [FilterBits-1:0]           fraction_v_o
);
  localparam int Side    = tex_pkg::MaxLog2Side;
  localparam int Address = tex_pkg::AddressBits;

  logic [Side-1:0] x, y;
  logic            outside_u, outside_v;
  coordinate #(.FilterBits(FilterBits)) u_coordinate_u (
    .coordinate_i(u_i), .log2_size_i(log2_width_i), .mode_i(mode_u_i), .point_i,
    .upper_i(corner_i[0]), .index_o(x), .outside_o(outside_u), .fraction_o(fraction_u_o)
  );
  coordinate #(.FilterBits(FilterBits)) u_coordinate_v (
    .coordinate_i(v_i), .log2_size_i(log2_height_i), .mode_i(mode_v_i), .point_i,
    .upper_i(corner_i[1]), .index_o(y), .outside_o(outside_v), .fraction_o(fraction_v_o)
  );
  assign outside_o = outside_u || outside_v;

  // Texels from one row of tiles to the next: a plane narrower than a tile still fills one.
  logic [tex_pkg::LevelBits:0] log2_tile_row;
  assign log2_tile_row = (log2_width_i > tex_pkg::LevelBits'(TileLog2Width)
                          ? {1'b0, log2_width_i} : (tex_pkg::LevelBits + 1)'(TileLog2Width))
                       + (tex_pkg::LevelBits + 1)'(TileLog2Height);

  logic [Address-3:0] row_major, tiled;
  assign row_major = (Address - 2)'(x) | ((Address - 2)'(y) << log2_width_i);
  assign tiled     = (Address - 2)'(x[TileLog2Width-1:0])
                   | ((Address - 2)'(y[TileLog2Height-1:0]) << TileLog2Width)
                   | ((Address - 2)'(x[Side-1:TileLog2Width]) << (TileLog2Width + TileLog2Height))
                   | ((Address - 2)'(y[Side-1:TileLog2Height]) << log2_tile_row);
  assign address_o = base_i + {tiled_i ? tiled : row_major, 2'b00};
endmodule : address
