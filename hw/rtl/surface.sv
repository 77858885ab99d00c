// The surface: the plane table of one texture (docs/numerics.md, section 2). A start walks through the
// planes, one a clock, and writes down where each begins; a look-up is combinational.
//
// A driver could write the table as well; walking keeps the alignment rule in one place and costs one
// adder, since all sizes are powers of two.
module surface #(
  // log2 of width and height of a tile in texels.
  parameter int TileLog2Width  = tex_pkg::TileLog2Width,
  parameter int TileLog2Height = tex_pkg::TileLog2Height
) (
  input  logic                            clk_i,
  input  logic                            rst_ni,
  // Lay out the planes; ignored while busy_o. The four inputs below must hold while busy and in use.
  input  logic                            start_i,
  input  logic                            dipmap_i,
  input  logic                            tiled_i,
  input  logic [tex_pkg::LevelBits-1:0]   log2_width_i,
  input  logic [tex_pkg::LevelBits-1:0]   log2_height_i,
  output logic                            busy_o,
  // Look-up.
  input  logic [tex_pkg::PlaneBits-1:0]   plane_i,
  output logic [tex_pkg::AddressBits-1:0] base_o,
  output logic [tex_pkg::LevelBits-1:0]   log2_width_o,
  output logic [tex_pkg::LevelBits-1:0]   log2_height_o
);
  localparam int Level = tex_pkg::LevelBits;
  localparam int Plane = tex_pkg::PlaneBits;

  logic                            busy_d, busy_q;
  logic [Plane-1:0]                plane_d, plane_q;
  logic [tex_pkg::AddressBits-1:0] next_d, next_q;
  logic [tex_pkg::AddressBits-1:0] base_q [tex_pkg::Planes];

  // Size of the plane asked for while idle, of the plane being laid out while busy.
  logic [Plane-1:0] plane, width_halvings, height_halvings;
  assign plane           = busy_q ? plane_q : plane_i;
  assign width_halvings  = !dipmap_i || plane <= Plane'(log2_width_i) ? plane : '0;
  assign height_halvings = !dipmap_i ? plane
                         : plane <= Plane'(log2_width_i) ? '0 : plane - Plane'(log2_width_i);
  assign log2_width_o    = width_halvings < Plane'(log2_width_i)
                         ? log2_width_i - width_halvings[Level-1:0] : '0;
  assign log2_height_o   = height_halvings < Plane'(log2_height_i)
                         ? log2_height_i - height_halvings[Level-1:0] : '0;
  assign base_o          = base_q[plane_i];

  // Padded to whole tiles, then to the alignment.
  logic [Level-1:0] least_width, least_height, padded_width, padded_height;
  logic [Level:0]   log2_bytes;
  assign least_width   = tiled_i ? Level'(TileLog2Width) : '0;
  assign least_height  = tiled_i ? Level'(TileLog2Height) : '0;
  assign padded_width  = log2_width_o > least_width ? log2_width_o : least_width;
  assign padded_height = log2_height_o > least_height ? log2_height_o : least_height;
  assign log2_bytes    = {1'b0, padded_width} + {1'b0, padded_height} + (Level + 1)'(2);

  logic [Plane-1:0] last_plane;
  assign last_plane = dipmap_i ? Plane'(log2_width_i) + Plane'(log2_height_i)
                    : log2_width_i > log2_height_i ? Plane'(log2_width_i) : Plane'(log2_height_i);

  always_comb begin
    busy_d  = busy_q;
    plane_d = plane_q;
    next_d  = next_q;
    if (busy_q) begin
      busy_d  = plane_q != last_plane;
      plane_d = plane_q + Plane'(1);
      next_d  = next_q + (tex_pkg::AddressBits'(1)
                << (log2_bytes > (Level + 1)'(tex_pkg::PlaneAlignmentLog2)
                    ? log2_bytes : (Level + 1)'(tex_pkg::PlaneAlignmentLog2)));
    end else if (start_i) begin
      busy_d  = 1'b1;
      plane_d = '0;
      next_d  = '0;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      busy_q  <= 1'b0;
      plane_q <= '0;
      next_q  <= '0;
    end else begin
      busy_q  <= busy_d;
      plane_q <= plane_d;
      next_q  <= next_d;
    end
  end

  // No reset: a plane is looked up only after it was laid out.
  always_ff @(posedge clk_i) begin
    if (busy_q) base_q[plane_q] <= next_q;
  end

  assign busy_o = busy_q;
endmodule : surface
