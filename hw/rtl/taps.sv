// The tap unit: a filter is a program of weighted taps (docs/numerics.md, section 5); this unit
// takes one request's levels and issues its texels, one a clock.
//
// Weights always sum to 256 here, whatever the filter: a single tap has 256, the two of the dipmap
// 128 each. The datapath then has one shift, and the result is the same (docs/hardware.md).
module taps (
  input  logic                            clk_i,
  input  logic                            rst_ni,
  // Held while a request is inside.
  input  logic [2:0]                      filter_i,
  // Last level of the mipmap's chain, and of the u axis.
  input  logic [tex_pkg::LevelBits-1:0]   last_i,
  input  logic [tex_pkg::LevelBits-1:0]   last_u_i,
  // A request: levels of lod.sv, of the only scale or that of u, then that of v.
  input  logic                            valid_i,
  output logic                            ready_o,
  input  logic [tex_pkg::LevelBits+7:0]   fractional_i,
  input  logic [tex_pkg::LevelBits-1:0]   whole_i,
  input  logic [tex_pkg::LevelBits-1:0]   level_u_i,
  input  logic [tex_pkg::LevelBits-1:0]   level_v_i,
  // A texel: plane, weight of its tap, corner of the tap; the last of its tap, of its request.
  output logic                            valid_o,
  input  logic                            ready_i,
  output logic [tex_pkg::PlaneBits-1:0]   plane_o,
  output logic [8:0]                      weight_o,
  output logic [1:0]                      corner_o,
  output logic                            point_o,
  output logic                            tap_end_o,
  output logic                            request_end_o,
  // The levels the response reports, 8.8.
  output logic [tex_pkg::LevelBits+7:0]   lod_u_o,
  output logic [tex_pkg::LevelBits+7:0]   lod_v_o
);
  localparam int Level = tex_pkg::LevelBits;
  localparam int Plane = tex_pkg::PlaneBits;

  logic             busy_d, busy_q, tap_d, tap_q;
  logic [1:0]       corner_d, corner_q;
  logic [Level+7:0] fractional_q;
  logic [Level-1:0] whole_q, level_u_q, level_v_q;
  logic             accept, two_taps;

  assign two_taps      = filter_i == tex_pkg::FilterTrilinear || filter_i == tex_pkg::FilterDipmap;
  assign point_o       = filter_i == tex_pkg::FilterPoint;
  assign valid_o       = busy_q;
  assign corner_o      = corner_q;
  assign tap_end_o     = point_o || corner_q == 2'd3;
  assign request_end_o = tap_end_o && (tap_q || !two_taps);
  // The next request enters in the clock in which the last texel leaves.
  assign ready_o       = !busy_q || (ready_i && request_end_o);
  assign accept        = valid_i && ready_o;

  logic [Level-1:0] fine, coarse;
  assign fine   = fractional_q[Level+7:8];
  assign coarse = fine < last_i ? fine + Level'(1) : last_i;

  always_comb begin
    plane_o  = '0;
    weight_o = 9'd256;
    lod_u_o  = '0;
    lod_v_o  = '0;
    case (filter_i)
      tex_pkg::FilterNearestMip: begin
        plane_o = Plane'(whole_q);
        lod_u_o = {whole_q, 8'd0};
        lod_v_o = {whole_q, 8'd0};
      end
      tex_pkg::FilterTrilinear: begin
        plane_o  = tap_q ? Plane'(coarse) : Plane'(fine);
        weight_o = tap_q ? {1'b0, fractional_q[7:0]} : 9'd256 - {1'b0, fractional_q[7:0]};
        lod_u_o  = fractional_q;
        lod_v_o  = fractional_q;
      end
      tex_pkg::FilterDipmap: begin
        // Plane (0, 0) is shared by the two pyramids (E11).
        plane_o  = !tap_q ? Plane'(level_u_q)
                 : level_v_q == '0 ? '0 : Plane'(last_u_i) + Plane'(level_v_q);
        weight_o = 9'd128;
        lod_u_o  = {level_u_q, 8'd0};
        lod_v_o  = {level_v_q, 8'd0};
      end
      default: ;
    endcase
  end

  always_comb begin
    busy_d   = busy_q;
    tap_d    = tap_q;
    corner_d = corner_q;
    if (busy_q && ready_i) begin
      corner_d = tap_end_o ? 2'd0 : corner_q + 2'd1;
      tap_d    = request_end_o ? 1'b0 : tap_q ^ tap_end_o;
      busy_d   = !request_end_o;
    end
    if (accept) busy_d = 1'b1;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      busy_q       <= 1'b0;
      tap_q        <= 1'b0;
      corner_q     <= 2'd0;
      fractional_q <= '0;
      whole_q      <= '0;
      level_u_q    <= '0;
      level_v_q    <= '0;
    end else begin
      busy_q   <= busy_d;
      tap_q    <= tap_d;
      corner_q <= corner_d;
      if (accept) begin
        fractional_q <= fractional_i;
        whole_q      <= whole_i;
        level_u_q    <= level_u_i;
        level_v_q    <= level_v_i;
      end
    end
  end

`ifdef FORMAL
  // Proved by induction (hw/formal/run): the weights of a request sum to 256, and no plane lies beyond the table.
  logic [8:0] sum_q = '0;
  logic [2:0] filter_q;
  initial begin
    busy_q   = 1'b0;
    tap_q    = 1'b0;
    corner_q = 2'd0;
  end
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) sum_q <= '0;
    else if (busy_q && ready_i && tap_end_o) sum_q <= request_end_o ? '0 : sum_q + weight_o;
  end
  always_ff @(posedge clk_i) filter_q <= filter_i;
  always_comb begin
    // The sampler is held while a request is inside; levels are within the chain.
    if (busy_q) assume (filter_i == filter_q);
    assume (fine <= last_i && whole_q <= last_i && level_u_q <= last_u_i && last_u_i <= last_i && level_v_q <= last_i);
    assume (last_i <= tex_pkg::LevelBits'(tex_pkg::MaxLog2Side));
    assert (tap_q || sum_q == '0);
    assert (!tap_q || busy_q && two_taps && sum_q + weight_o == 9'd256);
    if (busy_q && request_end_o) assert (sum_q + weight_o == 9'd256);
    if (busy_q) assert (plane_o < tex_pkg::PlaneBits'(tex_pkg::Planes));
  end
`endif
endmodule : taps
