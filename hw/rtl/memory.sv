// The data banks of the cache: one 32-bit bank a texel of a line, so that a fill takes one clock and
// a read addresses one texel. Read is registered, as SRAM is; a fill is read through.
module memory #(
  // Lines held.
  parameter int Slots = tex_pkg::Sets * tex_pkg::Ways,
  // Texels of a line.
  parameter int Texels = (1 << tex_pkg::LineLog2Bytes) / 4
) (
  input  logic                      clk_i,
  // Do anything at all; the output holds otherwise.
  input  logic                      enable_i,
  // Write the line into the slot first.
  input  logic                      fill_i,
  input  logic [$clog2(Slots)-1:0]  slot_i,
  input  logic [32*Texels-1:0]      line_i,
  input  logic [$clog2(Texels)-1:0] texel_i,
  // The texel, one clock later: red in the lowest byte.
  output logic [31:0]               texel_o
);
  logic [32*Texels-1:0]      line;
  logic [$clog2(Texels)-1:0] texel_q;

  for (genvar bank = 0; bank < Texels; bank++) begin : gen_bank
    logic [31:0] word_q [Slots];
    logic [31:0] read_q;
    always_ff @(posedge clk_i) begin
      if (enable_i) begin
        if (fill_i) word_q[slot_i] <= line_i[32*bank +: 32];
        read_q <= fill_i ? line_i[32*bank +: 32] : word_q[slot_i];
      end
    end
    assign line[32*bank +: 32] = read_q;
  end

  always_ff @(posedge clk_i) begin
    if (enable_i) texel_q <= texel_i;
  end
  assign texel_o = line[32*texel_q +: 32];
endmodule : memory
