// The whole unit against a golden trace of `texunit trace record`, read as it is, and the texture memory of
// `texunit trace memory`. The same testbench in Verilator and Icarus; hw/tb/golden makes its arguments of the trace's head.
//
// Two passes from an empty cache each. First one request at a time, so that the counters give the look-ups and misses of
// each; then all of them as fast as they are taken, with a memory that hesitates and responses that are not taken at once.
module tb;
  parameter int Log2              = tex_pkg::Log2;
  parameter int LodBits           = tex_pkg::LodBits;
  parameter int FilterBits        = tex_pkg::FilterBits;
  parameter int Rounding          = tex_pkg::Rounding;
  parameter int Sets              = tex_pkg::Sets;
  parameter int Ways              = tex_pkg::Ways;
  localparam int MaxRecords       = 1 << 16;
  localparam int MaxWords         = 1 << 22;
  // Clocks in which an answer must come.
  localparam int Patience         = 20000;

  // What is on disk: records of 384 bits, words of 32, byte 0 lowest.
  logic [383:0]  trace  [0:MaxRecords-1];
  logic [31:0]   memory [0:MaxWords-1];
  logic [8191:0] path;
  integer        count, words, log2_width, log2_height, choice, level;

  // Of one record.
  logic [31:0]  u, v, scale_u, scale_v, texel_wanted;
  logic [127:0] unused_axes;
  logic [31:0]  unused_pixel;
  logic [15:0]  lod_u_wanted, lod_v_wanted, reads_wanted, misses_wanted;

  logic         clk = 0;
  logic         rst_n = 1;
  always #5 clk = !clk;

  logic [2:0]   filter;
  logic [1:0]   mode_u, mode_v, level_rounding;
  logic         explicit_level, tiled;
  logic [13:0]  bias, min_lod, max_lod;
  logic         bind_valid, request_valid, response_ready, memory_ready, line_valid;
  logic [511:0] line;
  wire          bind_ready, request_ready, response_valid, memory_valid, line_ready, access_valid, access_hit;
  wire  [31:0]  texel, requests, lookups, misses;
  wire  [15:0]  lod_u, lod_v;
  wire  [21:0]  memory_line;
  wire  [27:0]  access_address;
  unit #(.Log2(Log2), .LodBits(LodBits), .FilterBits(FilterBits), .Rounding(Rounding), .Sets(Sets), .Ways(Ways)) u_unit (
    .clk_i(clk), .rst_ni(rst_n), .bind_valid_i(bind_valid), .bind_ready_o(bind_ready), .filter_i(filter),
    .mode_u_i(mode_u), .mode_v_i(mode_v), .explicit_i(explicit_level), .level_rounding_i(level_rounding), .tiled_i(tiled),
    .log2_width_i(log2_width[3:0]), .log2_height_i(log2_height[3:0]), .bias_i(bias), .min_lod_i(min_lod),
    .max_lod_i(max_lod), .request_valid_i(request_valid), .request_ready_o(request_ready), .u_i(u), .v_i(v),
    .scale_u_i(scale_u), .scale_v_i(scale_v), .response_valid_o(response_valid), .response_ready_i(response_ready),
    .texel_o(texel), .lod_u_o(lod_u), .lod_v_o(lod_v), .memory_request_valid_o(memory_valid),
    .memory_request_ready_i(memory_ready), .memory_request_line_o(memory_line), .memory_response_valid_i(line_valid),
    .memory_response_ready_o(line_ready), .memory_response_data_i(line), .access_valid_o(access_valid),
    .access_hit_o(access_hit), .access_address_o(access_address), .requests_o(requests), .lookups_o(lookups),
    .misses_o(misses), .fifo_stalls_o(), .request_stalls_o(), .line_stalls_o()
  );

  // The record that waits for its answer, and the one whose look-ups come next with what it had of them.
  integer answered, looking, looked, missed;
  integer responses, all_reads, all_misses, waited, at, i, stalled, pass;
  logic   hesitate, bound, taken;
  // Lines on their way: never more than the FIFO holds texels.
  logic [21:0] asked [256];
  integer      asked_written, asked_read;
  logic [31:0] noise;

  function automatic [31:0] next(input [31:0] state);
    next = state * 32'd1664525 + 32'd1013904223;
  endfunction

  // An X in what was found differs from everything.
  task automatic expect_value(input integer record, input [63:0] wanted, input [63:0] found, input [8*20-1:0] what);
    if (found !== wanted) begin
      $display("FAIL record %0d (pass %0d): %0s is %0h, not %0h", record, pass, what, found, wanted);
      $fatal(1);
    end
  endtask

  // Records without reads have no look-ups to wait for; in the first pass none is ahead of its request.
  task automatic skip_silent;
    while (looking < count && (hesitate || looking <= at) && trace[looking][31:16] == 16'd0) begin
      expect_value(looking, 64'(trace[looking][15:0]), 0, "misses");
      looking = looking + 1;
    end
  endtask

  task automatic clock;
    noise = next(noise);
    response_ready = !hesitate || stalled == 0;
    if (stalled != 0) stalled = stalled - 1;
    memory_ready = !hesitate || noise[31];
    line_valid = asked_read != asked_written && (!hesitate || noise[30:29] != 2'd0);
    for (i = 0; i < 16; i = i + 1) line[32*i +: 32] = line_valid ? memory[{asked[asked_read % 256], i[3:0]} % MaxWords] : 32'bx;
    #4;
    bound = bind_valid && bind_ready;
    taken = request_valid && request_ready;
    if (line_valid && line_ready) asked_read = asked_read + 1;
    // A line is asked for when a look-up misses, and at no other time.
    expect_value(answered, 64'(access_valid && !access_hit), 64'(memory_valid && memory_ready), "line asked for");
    if (memory_valid !== 1'b0 && memory_ready) begin
      expect_value(answered, 1, 64'({memory_line, 4'd0} < words), "line in the memory");
      asked[asked_written % 256] = memory_line;
      asked_written = asked_written + 1;
    end
    if (access_valid !== 1'b0) begin
      skip_silent;
      expect_value(looking, 1, 64'(looking < count), "look-up asked for");
      looked = looked + 1;
      all_reads = all_reads + 1;
      if (access_hit !== 1'b1) begin
        missed = missed + 1;
        all_misses = all_misses + 1;
      end
      if (looked == 32'(trace[looking][31:16])) begin
        expect_value(looking, 64'(trace[looking][15:0]), 64'(missed), "misses");
        looking = looking + 1;
        looked = 0;
        missed = 0;
      end
    end
    if (response_valid !== 1'b0) begin
      expect_value(answered, 1, 64'(answered < count), "response asked for");
      {unused_pixel, texel_wanted, lod_u_wanted, lod_v_wanted, reads_wanted, misses_wanted} = trace[answered][127:0];
      // The trace has red in the highest byte, the unit as memory has it.
      expect_value(answered, 64'({texel_wanted[7:0], texel_wanted[15:8], texel_wanted[23:16], texel_wanted[31:24]}),
                   64'(texel), "texel (alpha first)");
      expect_value(answered, 64'(lod_u_wanted), 64'(lod_u), "lod0");
      expect_value(answered, 64'(lod_v_wanted), 64'(lod_v), "lod1");
      if (response_ready) begin
        answered = answered + 1;
        responses = responses + 1;
        if (hesitate) stalled = 32'(noise[20:18]);
      end
    end
    waited = waited + 1;
    expect_value(answered, 1, 64'(waited < Patience), "patience");
    @(negedge clk);
  endtask

  task automatic argument(input integer given);
    if (given == 0) begin
      $display("FAIL an argument is missing: hw/tb/golden TRACE prints them");
      $fatal(1);
    end
  endtask

  // X also in what should have been there.
  task automatic load;
    integer word;
    argument($value$plusargs("count=%d", count));
    argument($value$plusargs("words=%d", words));
    if (count < 1 || count > MaxRecords || words < 1 || words > MaxWords) begin
      $display("FAIL %0d records, %0d words: at most %0d and %0d", count, words, MaxRecords, MaxWords);
      $fatal(1);
    end
    trace[count-1] = 384'bx;
    memory[words-1] = 32'bx;
    argument($value$plusargs("trace=%s", path));
    $readmemh(path, trace, 0, count - 1);
    argument($value$plusargs("memory=%s", path));
    $readmemh(path, memory, 0, words - 1);
    if (^trace[count-1] === 1'bx || ^memory[words-1] === 1'bx) begin
      $display("FAIL the trace or the memory is short");
      $fatal(1);
    end
    argument($value$plusargs("filter=%d", choice));         filter = choice[2:0];
    argument($value$plusargs("mode_u=%d", choice));         mode_u = choice[1:0];
    argument($value$plusargs("mode_v=%d", choice));         mode_v = choice[1:0];
    argument($value$plusargs("explicit=%d", choice));       explicit_level = choice[0];
    argument($value$plusargs("level_rounding=%d", choice)); level_rounding = choice[1:0];
    argument($value$plusargs("tiled=%d", choice));          tiled = choice[0];
    argument($value$plusargs("log2_width=%d", log2_width));
    argument($value$plusargs("log2_height=%d", log2_height));
    argument($value$plusargs("bias=%h", level));            bias = level[13:0];
    argument($value$plusargs("min_lod=%h", level));         min_lod = level[13:0];
    argument($value$plusargs("max_lod=%h", level));         max_lod = level[13:0];
  endtask

  task automatic start;
    bind_valid = 0;
    request_valid = 0;
    response_ready = 0;
    memory_ready = 0;
    line_valid = 0;
    {answered, looking, looked, missed, stalled, asked_written, asked_read, waited} = 0;
    @(negedge clk) rst_n = 0;
    @(negedge clk);
    @(negedge clk) rst_n = 1;
    bind_valid = 1;
    bound = 0;
    while (!bound) clock;
    bind_valid = 0;
  endtask

  initial begin
    noise = 1;
    {responses, all_reads, all_misses} = 0;
    load;
    for (pass = 1; pass <= 2; pass = pass + 1) begin
      hesitate = pass == 2;
      start;
      for (at = 0; at < count; at = at + 1) begin
        {u, v, scale_u, scale_v, unused_axes} = trace[at][383:128];
        request_valid = 1;
        taken = 0;
        waited = 0;
        while (!taken) clock;
        if (!hesitate || at == count - 1) begin
          request_valid = 0;
          while (answered <= at) clock;
        end
        if (!hesitate) begin
          // Nothing of it is under way any more: all its look-ups were counted.
          skip_silent;
          expect_value(at, 64'(at) + 1, 64'(looking), "records whose reads were seen");
          expect_value(at, 0, 64'(looked), "reads too many");
        end
      end
      skip_silent;
      expect_value(count, 64'(count), 64'(looking), "records whose reads were seen");
      expect_value(count, 64'(count), 64'(requests), "requests_o");
      expect_value(count, 64'(all_reads), 64'(pass) * 64'(lookups), "lookups_o");
      expect_value(count, 64'(all_misses), 64'(pass) * 64'(misses), "misses_o");
    end
    $display("PASS %0d records twice: %0d responses, %0d reads, %0d misses", count, responses, all_reads, all_misses);
    $finish;
  end
endmodule
