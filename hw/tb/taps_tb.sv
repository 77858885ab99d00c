// taps.sv against its trace.
module tb;
  localparam int Width = 6 * 4 + 16 + 4 * 4 + 8 + 12 + 8 + 12 + 2 * 16;
  `include "trace.svh"
  `include "clock.svh"
  // The line being sent, and that of the request inside.
  logic [3:0]  clear, idle, stall, filter = 0, last = 0, last_u = 0, whole, level_u, level_v, taps_in;
  logic [3:0]  next_filter, next_last, next_last_u, taps_inside;
  logic [15:0] fractional, lod_u_in, lod_v_in, lod_u_inside, lod_v_inside;
  logic [7:0]  plane_0, plane_1;
  logic [11:0] weight_0, weight_1;
  logic [7:0]  plane_inside [2];
  logic [11:0] weight_inside [2];
  logic        valid_in = 0, ready_in = 0, taken, busy = 0;
  wire         ready_out, valid_out, point, tap_end, request_end;
  wire  [4:0]  plane;
  wire  [8:0]  weight;
  wire  [1:0]  corner;
  wire  [11:0] lod_u, lod_v;
  integer      tap = 0, corner_wanted = 0, stalled = 0, texels = 0, resets = 0, i;
  taps u_taps (
    .clk_i(clk), .rst_ni(rst_n), .filter_i(filter[2:0]), .last_i(last), .last_u_i(last_u), .valid_i(valid_in),
    .ready_o(ready_out), .fractional_i(fractional[11:0]), .whole_i(whole), .level_u_i(level_u), .level_v_i(level_v),
    .valid_o(valid_out), .ready_i(ready_in), .plane_o(plane), .weight_o(weight), .corner_o(corner), .point_o(point),
    .tap_end_o(tap_end), .request_end_o(request_end), .lod_u_o(lod_u), .lod_v_o(lod_v)
  );
  task automatic clock;
    ready_in = stalled == 0;
    if (stalled != 0) stalled = stalled - 1;
    #4;
    taken = valid_in && ready_out;
    expect_value(busy, valid_out, "valid_o");
    // The next request enters when nobody is inside, or with the last texel of the one that is.
    expect_value(!valid_out || (ready_in && request_end), ready_out, "ready_o");
    if (valid_out && ready_in) begin
      expect_value(plane_inside[tap], plane, "plane");
      expect_value(weight_inside[tap], weight, "weight");
      expect_value(corner_wanted, corner, "corner");
      expect_value(filter == 0, point, "point");
      expect_value(filter == 0 || corner_wanted == 3, tap_end, "tap_end");
      expect_value(tap_end && tap + 1 == taps_inside, request_end, "request_end");
      expect_value(lod_u_inside, lod_u, "lod_u");
      expect_value(lod_v_inside, lod_v, "lod_v");
      texels = texels + 1;
      corner_wanted = tap_end ? 0 : corner_wanted + 1;
      if (tap_end) tap = tap + 1;
      busy = !request_end;
    end
    @(negedge clk);
  endtask
  initial begin
    load;
    reset;
    for (at = 0; at < Count; at = at + 1) begin
      valid_in = 0;
      {clear, idle, stall, next_filter, next_last, next_last_u, fractional, whole, level_u, level_v, taps_in,
       plane_0, weight_0, plane_1, weight_1, lod_u_in, lod_v_in} = trace[at];
      // The sampler and texture change only when nobody is inside.
      while (busy && {next_filter, next_last, next_last_u} != {filter, last, last_u}) clock;
      if (clear != 0) begin
        reset;
        busy = 0;
        stalled = 0;
        resets = resets + 1;
      end
      {filter, last, last_u} = {next_filter, next_last, next_last_u};
      for (i = 0; i < idle; i = i + 1) clock;
      valid_in = 1;
      taken = 0;
      while (!taken) clock;
      busy = 1;
      tap = 0;
      corner_wanted = 0;
      taps_inside = taps_in;
      plane_inside[0] = plane_0;
      plane_inside[1] = plane_1;
      weight_inside[0] = weight_0;
      weight_inside[1] = weight_1;
      lod_u_inside = lod_u_in;
      lod_v_inside = lod_v_in;
      stalled = stall;
    end
    valid_in = 0;
    while (busy) clock;
    $display("PASS taps %0d requests %0d texels %0d resets", Count, texels, resets);
    $finish;
  end
endmodule
