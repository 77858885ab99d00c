// The whole unit against its trace, with a memory that hesitates.
module tb;
  parameter int Sets = tex_pkg::Sets;
  parameter int Ways = tex_pkg::Ways;
  parameter int FilterBits = tex_pkg::FilterBits;
  parameter int LodBits = tex_pkg::LodBits;
  parameter int Rounding = tex_pkg::Rounding;
  parameter int FragmentFifoDepth = tex_pkg::FragmentFifoDepth;
  localparam int Width = 3 * 4 + 4 * 32 + 32 + 2 * 16 + 4 + 8;
  `include "trace.svh"
  `include "clock.svh"
  logic [3:0]   op, idle, stall, accesses;
  logic [31:0]  u, v, scale_u, scale_v, texel_wanted;
  logic [15:0]  lod_u_wanted, lod_v_wanted;
  logic [7:0]   hits;
  logic         bind_valid = 0, request_valid = 0, response_ready = 0, memory_ready = 0, line_valid = 0;
  logic [511:0] line;
  wire          bind_ready, request_ready, response_valid, memory_valid, line_ready, access_valid, access_hit;
  wire  [31:0]  texel, requests, lookups, misses;
  wire  [15:0]  lod_u, lod_v;
  wire  [21:0]  memory_line;
  unit #(.Sets(Sets), .Ways(Ways), .FilterBits(FilterBits), .LodBits(LodBits), .Rounding(Rounding),
         .FragmentFifoDepth(FragmentFifoDepth)) u_unit (
    .clk_i(clk), .rst_ni(rst_n), .bind_valid_i(bind_valid), .bind_ready_o(bind_ready), .filter_i(u[30:28]),
    .mode_u_i(u[25:24]), .mode_v_i(u[21:20]), .explicit_i(u[16]), .level_rounding_i(u[13:12]), .tiled_i(u[8]),
    .log2_width_i(u[7:4]), .log2_height_i(u[3:0]), .bias_i(v[13:0]), .min_lod_i(scale_u[29:16]),
    .max_lod_i(scale_u[13:0]), .request_valid_i(request_valid), .request_ready_o(request_ready), .u_i(u), .v_i(v),
    .scale_u_i(scale_u), .scale_v_i(scale_v), .response_valid_o(response_valid), .response_ready_i(response_ready),
    .texel_o(texel), .lod_u_o(lod_u), .lod_v_o(lod_v), .memory_request_valid_o(memory_valid),
    .memory_request_ready_i(memory_ready), .memory_request_line_o(memory_line), .memory_response_valid_i(line_valid),
    .memory_response_ready_o(line_ready), .memory_response_data_i(line), .access_valid_o(access_valid),
    .access_hit_o(access_hit), .access_address_o(), .requests_o(requests), .lookups_o(lookups), .misses_o(misses),
    .fifo_stalls_o(), .request_stalls_o(), .line_stalls_o()
  );

  // Rings of what is on its way.
  logic [63:0]  wanted [256];
  logic         access_wanted [1024];
  logic [21:0]  asked [256];
  integer       written = 0, read = 0, accesses_written = 0, accesses_read = 0, asked_written = 0, asked_read = 0;
  integer       stalled = 0, responses = 0, looked = 0, missed = 0, resets = 0, since_reset = 0, i, pause, seed = 1;
  logic         bound, taken;

  function automatic [31:0] word_at(input [31:0] word);
    reg [31:0] h;
    h = word * 32'h9e3779b1;
    h = (h ^ (h >> 15)) * 32'h85ebca77;
    word_at = h ^ (h >> 13);
  endfunction

  task automatic clock;
    response_ready = stalled == 0;
    if (stalled != 0) stalled = stalled - 1;
    memory_ready = $random(seed) & 1;
    line_valid = asked_read != asked_written && ($random(seed) & 3) != 0;
    for (i = 0; i < 16; i = i + 1) line[32*i +: 32] = line_valid ? word_at(asked[asked_read % 256] * 16 + i) : 32'bx;
    #4;
    bound = bind_valid && bind_ready;
    taken = request_valid && request_ready;
    if (line_valid && line_ready) asked_read = asked_read + 1;
    if (memory_valid !== 1'b0 && memory_ready) begin
      asked[asked_written % 256] = memory_line;
      asked_written = asked_written + 1;
    end
    // A line is asked for when a look-up misses, and at no other time.
    expect_value(access_valid && !access_hit, memory_valid && memory_ready, "line asked for");
    if (access_valid !== 1'b0) begin
      expect_value(1, accesses_read != accesses_written, "look-up asked for");
      expect_value(access_wanted[accesses_read % 1024], access_hit, "hit");
      accesses_read = accesses_read + 1;
      looked = looked + 1;
      if (!access_hit) missed = missed + 1;
    end
    if (response_valid !== 1'b0) begin
      expect_value(1, read != written, "response asked for");
      expect_value(wanted[read % 256], {texel, lod_u, lod_v}, "response");
      if (response_ready) begin
        read = read + 1;
        responses = responses + 1;
      end
    end
    @(negedge clk);
  endtask

  initial begin
    load;
    reset;
    for (at = 0; at < Count; at = at + 1) begin
      bind_valid = 0;
      request_valid = 0;
      {op, idle, stall, u, v, scale_u, scale_v, texel_wanted, lod_u_wanted, lod_v_wanted, accesses, hits} = trace[at];
      if (op == 4'd2) begin
        reset;
        read = written;
        accesses_read = accesses_written;
        asked_read = asked_written;
        stalled = 0;
        since_reset = 0;
        resets = resets + 1;
      end else begin
        for (pause = 0; pause < idle; pause = pause + 1) clock;
        if (op == 4'd1) begin
          bind_valid = 1;
          bound = 0;
          while (!bound) clock;
        end else begin
          request_valid = 1;
          taken = 0;
          while (!taken) clock;
          since_reset = since_reset + 1;
          wanted[written % 256] = {texel_wanted, lod_u_wanted, lod_v_wanted};
          written = written + 1;
          for (i = 0; i < accesses; i = i + 1) begin
            access_wanted[accesses_written % 1024] = hits[i];
            accesses_written = accesses_written + 1;
          end
          stalled = stall;
        end
      end
    end
    bind_valid = 0;
    request_valid = 0;
    while (read != written) clock;
    expect_value(accesses_written, accesses_read, "look-ups");
    expect_value(since_reset, requests, "requests_o");
    $display("PASS unit %0d lines %0d responses %0d look-ups %0d misses %0d resets", Count, responses, looked, missed,
             resets);
    $finish;
  end
endmodule
