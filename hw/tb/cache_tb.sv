// cache.sv against its trace, clock by clock.
module tb;
  parameter int Sets = 4;
  parameter int Ways = 4;
  localparam int Width = 3 * 4 + 24 + 2 * 4;
  localparam int WayBits = Ways > 1 ? $clog2(Ways) : 1;
  `include "trace.svh"
  `include "clock.svh"
  logic [3:0]         clear, flush = 0, update = 0, wanted_hit, wanted_way;
  logic [23:0]        line;
  wire                hit;
  wire  [WayBits-1:0] way;
  wire  [$clog2(Sets)-1:0] set;
  integer             hits = 0;
  cache #(.Sets(Sets), .Ways(Ways)) u_cache (
    .clk_i(clk), .rst_ni(rst_n), .flush_i(flush[0]), .line_i(line[21:0]), .update_i(update[0]),
    .hit_o(hit), .way_o(way), .set_o(set)
  );
  initial begin
    load;
    for (at = 0; at < Count; at = at + 1) begin
      @(negedge clk);
      {clear, flush, update, line, wanted_hit, wanted_way} = trace[at];
      rst_n = clear == 0;
      #4;
      expect_value(wanted_hit, hit, "hit");
      expect_value(wanted_way, way, "way");
      if (hit) hits = hits + 1;
    end
    $display("PASS cache %0d clocks %0d hits", Count, hits);
    $finish;
  end
endmodule
