// datapath.sv against its trace.
module tb;
  parameter int FilterBits = tex_pkg::FilterBits;
  parameter int Rounding = tex_pkg::Rounding;
  localparam int Width = 5 * 4 + 2 * (4 * 32 + 3 * 12) + 32;
  `include "trace.svh"
  `include "clock.svh"
  logic [3:0]   clear, idle, stall, taps, point;
  // Texels of a tap from the left, then fractions and weight.
  logic [163:0] tap_0, tap_1, tap;
  logic [31:0]  wanted_texel;
  logic         valid_in = 0, ready_in = 0, request_end, tag_in, taken;
  logic [31:0]  texel_in;
  logic [1:0]   corner;
  logic [11:0]  fraction_u, fraction_v, weight;
  wire          ready_out, valid_out, tag_out;
  wire  [31:0]  texel_out;
  // Responses on their way: a ring longer than what fits inside.
  logic [32:0]  wanted [16];
  integer       written = 0, read = 0, stalled = 0, responses = 0, resets = 0, i, j, all, corners;
  datapath #(.FilterBits(FilterBits), .Rounding(Rounding)) u_datapath (
    .clk_i(clk), .rst_ni(rst_n), .valid_i(valid_in), .ready_o(ready_out), .texel_i(texel_in), .corner_i(corner),
    .point_i(point[0]), .request_end_i(request_end), .fraction_u_i(fraction_u[FilterBits-1:0]),
    .fraction_v_i(fraction_v[FilterBits-1:0]), .weight_i(weight[8:0]), .tag_i(tag_in), .valid_o(valid_out),
    .ready_i(ready_in), .texel_o(texel_out), .tag_o(tag_out)
  );
  task automatic clock;
    ready_in = stalled == 0;
    if (stalled != 0) stalled = stalled - 1;
    #4;
    taken = valid_in && ready_out;
    if (valid_out !== 1'b0) begin
      expect_value(1, written != read, "asked for");
      expect_value(wanted[read % 16], {tag_out, texel_out}, "texel");
      if (ready_in) begin
        read = read + 1;
        responses = responses + 1;
      end
    end
    @(negedge clk);
  endtask
  task automatic send(input integer count);
    corners = point != 0 ? 1 : 4;
    all = taps * corners;
    for (i = 0; i < count; i = i + 1) begin
      corner = i % corners;
      tap = i < corners ? tap_0 : tap_1;
      valid_in = 0;
      for (j = 0; j < (idle >> corner); j = j + 1) clock;
      valid_in = 1;
      texel_in = tap[132 - 32*corner +: 32];
      {fraction_u, fraction_v, weight} = tap[35:0];
      request_end = i + 1 == all;
      // Only the last texel's counts.
      tag_in = at[0] ^ !request_end;
      taken = 0;
      while (!taken) clock;
      if (request_end) begin
        wanted[written % 16] = {at[0], wanted_texel};
        written = written + 1;
      end
    end
    valid_in = 0;
  endtask
  initial begin
    load;
    reset;
    for (at = 0; at < Count; at = at + 1) begin
      {clear, idle, stall, taps, point, tap_0, tap_1, wanted_texel} = trace[at];
      if (clear != 0) begin
        send(taps * (point != 0 ? 1 : 4) - 1);
        reset;
        read = written;
        stalled = 0;
        resets = resets + 1;
      end
      send(taps * (point != 0 ? 1 : 4));
      stalled = stall;
    end
    while (read != written) clock;
    $display("PASS datapath %0d requests %0d responses %0d resets", Count, responses, resets);
    $finish;
  end
endmodule
