// surface.sv against its trace.
module tb;
  localparam int Width = 5 * 4 + 8 + 32 + 2 * 4 + 8;
  `include "trace.svh"
  `include "clock.svh"
  logic [3:0]  op = 0, dipmap, tiled, log2_width, log2_height, wanted_width, wanted_height;
  logic [7:0]  plane, wanted_clocks;
  logic [31:0] wanted_base;
  wire         busy;
  wire  [27:0] base;
  wire  [3:0]  plane_log2_width, plane_log2_height;
  integer      clocks, looked = 0;
  surface u_surface (
    .clk_i(clk), .rst_ni(rst_n), .start_i(op == 4'd1), .dipmap_i(dipmap[0]), .tiled_i(tiled[0]),
    .log2_width_i(log2_width), .log2_height_i(log2_height), .busy_o(busy), .plane_i(plane[4:0]), .base_o(base),
    .log2_width_o(plane_log2_width), .log2_height_o(plane_log2_height)
  );
  initial begin
    load;
    reset;
    for (at = 0; at < Count; at = at + 1) begin
      {op, dipmap, tiled, log2_width, log2_height, plane, wanted_base, wanted_width, wanted_height, wanted_clocks}
          = trace[at];
      if (op == 4'd3) begin
        reset;
        expect_value(0, busy, "busy after reset");
      end else begin
        if (op == 4'd2) begin
          for (clocks = 0; busy !== 1'b0 && clocks < 100; clocks = clocks + 1) @(negedge clk);
          if (clocks != 0) expect_value(wanted_clocks, clocks, "clocks");
          #1;
          expect_value(wanted_base, base, "base");
          expect_value(wanted_width, plane_log2_width, "plane_log2_width");
          expect_value(wanted_height, plane_log2_height, "plane_log2_height");
          looked = looked + 1;
        end
        @(negedge clk);
      end
    end
    $display("PASS surface %0d lines %0d look-ups", Count, looked);
    $finish;
  end
endmodule
