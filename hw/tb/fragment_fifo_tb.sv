// fragment_fifo.sv against its trace, clock by clock. (Width is that of a trace line here; entries have 16 bits.)
module tb;
  parameter int Depth = 8;
  localparam int Width = 3 * 4 + 16 + 2 * 4 + 16 + 8;
  `include "trace.svh"
  `include "clock.svh"
  logic [3:0]  clear, valid_in = 0, ready_in = 0, wanted_ready, wanted_valid;
  logic [15:0] data_in, wanted_data;
  logic [7:0]  wanted_held;
  wire         ready_out, valid_out;
  wire  [15:0] data_out;
  wire  [$clog2(Depth):0] held;
  integer      read = 0;
  fragment_fifo #(.Width(16), .Depth(Depth)) u_fragment_fifo (
    .clk_i(clk), .rst_ni(rst_n), .valid_i(valid_in[0]), .ready_o(ready_out), .data_i(data_in),
    .valid_o(valid_out), .ready_i(ready_in[0]), .data_o(data_out), .held_o(held)
  );
  initial begin
    load;
    for (at = 0; at < Count; at = at + 1) begin
      @(negedge clk);
      {clear, valid_in, ready_in, data_in, wanted_ready, wanted_valid, wanted_data, wanted_held} = trace[at];
      rst_n = clear == 0;
      #4;
      expect_value(wanted_ready, ready_out, "ready_o");
      expect_value(wanted_valid, valid_out, "valid_o");
      expect_value(wanted_held, held, "held_o");
      if (valid_out) expect_value(wanted_data, data_out, "data_o");
      if (valid_out && ready_in != 0 && rst_n) read = read + 1;
    end
    $display("PASS fragment_fifo %0d clocks %0d entries", Count, read);
    $finish;
  end
endmodule
