// memory.sv against its trace, clock by clock.
module tb;
  parameter int Slots = 8;
  localparam int Width = 2 * 4 + 8 + 32 + 2 * 4 + 32;
  `include "trace.svh"
  `include "clock.svh"
  logic [3:0]   enable = 0, fill, word, known;
  logic [7:0]   slot;
  logic [31:0]  seed, wanted;
  logic [511:0] line;
  wire  [31:0]  texel;
  integer       i, compared = 0;
  memory #(.Slots(Slots), .Texels(16)) u_memory (
    .clk_i(clk), .enable_i(enable[0]), .fill_i(fill[0]), .slot_i(slot[$clog2(Slots)-1:0]), .line_i(line),
    .texel_i(word), .texel_o(texel)
  );
  initial begin
    load;
    @(negedge clk);
    for (at = 0; at < Count; at = at + 1) begin
      {enable, fill, slot, seed, word, known, wanted} = trace[at];
      for (i = 0; i < 16; i = i + 1) line[32*i +: 32] = seed + i * 32'h9e3779b1;
      @(negedge clk);
      if (known != 0) begin
        expect_value(wanted, texel, "texel");
        compared = compared + 1;
      end
    end
    $display("PASS memory %0d clocks %0d texels", Count, compared);
    $finish;
  end
endmodule
