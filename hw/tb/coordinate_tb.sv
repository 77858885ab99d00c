// coordinate.sv against its trace.
module tb;
  localparam int Width = 32 + 4 * 4 + 16 + 4 + 12;
  `include "trace.svh"
  logic [31:0] coordinate;
  logic [3:0]  log2_size, mode, point, upper, wanted_outside;
  logic [15:0] wanted_index;
  logic [11:0] wanted_fraction;
  wire  [11:0] index;
  wire  [7:0]  fraction;
  wire         outside;
  coordinate u_coordinate (
    .coordinate_i(coordinate), .log2_size_i(log2_size), .mode_i(mode[1:0]), .point_i(point[0]), .upper_i(upper[0]),
    .index_o(index), .outside_o(outside), .fraction_o(fraction)
  );
  initial begin
    load;
    for (at = 0; at < Count; at = at + 1) begin
      {coordinate, log2_size, mode, point, upper, wanted_index, wanted_outside, wanted_fraction} = trace[at];
      #1;
      expect_value(wanted_outside, outside, "outside");
      if (!outside) expect_value(wanted_index, index, "index");
      expect_value(wanted_fraction, fraction, "fraction");
    end
    $display("PASS coordinate %0d vectors", Count);
    $finish;
  end
endmodule
