// address.sv against its trace.
module tb;
  localparam int Width = 3 * 32 + 7 * 4 + 32 + 4 + 2 * 12;
  `include "trace.svh"
  logic [31:0] u, v, base, wanted_address;
  logic [3:0]  log2_width, log2_height, mode_u, mode_v, tiled, point, corner, wanted_outside;
  logic [11:0] wanted_fraction_u, wanted_fraction_v;
  wire  [27:0] address;
  wire  [7:0]  fraction_u, fraction_v;
  wire         outside;
  address u_address (
    .u_i(u), .v_i(v), .base_i(base[27:0]), .log2_width_i(log2_width), .log2_height_i(log2_height),
    .mode_u_i(mode_u[1:0]), .mode_v_i(mode_v[1:0]), .tiled_i(tiled[0]), .point_i(point[0]), .corner_i(corner[1:0]),
    .address_o(address), .outside_o(outside), .fraction_u_o(fraction_u), .fraction_v_o(fraction_v)
  );
  initial begin
    load;
    for (at = 0; at < Count; at = at + 1) begin
      {u, v, base, log2_width, log2_height, mode_u, mode_v, tiled, point, corner,
       wanted_address, wanted_outside, wanted_fraction_u, wanted_fraction_v} = trace[at];
      #1;
      expect_value(wanted_outside, outside, "outside");
      if (!outside) expect_value(wanted_address, address, "address");
      expect_value(wanted_fraction_u, fraction_u, "fraction_u");
      expect_value(wanted_fraction_v, fraction_v, "fraction_v");
    end
    $display("PASS address %0d vectors", Count);
    $finish;
  end
endmodule
