// Generated from hw/profiles/herf-12.20.toml: TEXUNIT_BLESS=1 cargo test --release -p texunit-hw --test rtl
//
// Every width the units share, every choice by number, and the default machine's parameters.
package tex_pkg;
  // Widths.
  localparam int CoordinateBits = 20;
  // Textures are powers of two up to this side.
  localparam int MaxLog2Side = 12;
  localparam int LevelBits = 4;
  // Of a dipmap with that side.
  localparam int Planes = 25;
  localparam int PlaneBits = 5;
  // Bytes of it.
  localparam int AddressBits = 28;
  localparam int PlaneAlignmentLog2 = 8;

  // Choices that are parameters.
  localparam int Log2Exact = 0;
  localparam int Log2Herf = 1;
  localparam int Log2Ilog2 = 2;
  localparam int RoundOnce = 0;
  localparam int RoundStaged = 1;
  localparam int RoundStagedTruncate = 2;

  // Choices that are inputs.
  localparam logic [2:0] FilterPoint = 3'd0;
  localparam logic [2:0] FilterBilinear = 3'd1;
  localparam logic [2:0] FilterNearestMip = 3'd2;
  localparam logic [2:0] FilterTrilinear = 3'd3;
  localparam logic [2:0] FilterDipmap = 3'd4;
  localparam logic [1:0] AddressWrap = 2'd0;
  localparam logic [1:0] AddressClamp = 2'd1;
  localparam logic [1:0] AddressClip = 2'd2;
  localparam logic [1:0] AddressMirror = 2'd3;
  localparam logic [1:0] LevelFloor = 2'd0;
  localparam logic [1:0] LevelNearest = 2'd1;
  localparam logic [1:0] LevelGl = 2'd2;

  // The default machine.
  localparam int Log2 = 0;
  localparam int LodBits = 8;
  localparam int FilterBits = 8;
  localparam int Rounding = 0;
  localparam int TileLog2Width = 2;
  localparam int TileLog2Height = 2;
  localparam int Sets = 64;
  localparam int Ways = 4;
  localparam int LineLog2Bytes = 6;
  // Texels between the tags and the data banks.
  localparam int FragmentFifoDepth = 32;
endpackage : tex_pkg
