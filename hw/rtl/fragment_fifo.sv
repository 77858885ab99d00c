// The fragment FIFO: what waits between the tags and the data banks while memory works (Igehy,
// Eldridge & Proudfoot 1998). First word falls through a register: what is written in one clock is
// seen in the next.
//
// It neither over- nor underflows whatever its neighbours do: a write counts only with ready_o, a
// read only with valid_o (proved in hw/formal).
module fragment_fifo #(
  // Bits of an entry.
  parameter int Width = 32,
  // Entries, at least 2, a power of two.
  parameter int Depth = tex_pkg::FragmentFifoDepth
) (
  input  logic                   clk_i,
  input  logic                   rst_ni,
  input  logic                   valid_i,
  output logic                   ready_o,
  input  logic [Width-1:0]       data_i,
  output logic                   valid_o,
  input  logic                   ready_i,
  output logic [Width-1:0]       data_o,
  // Entries held.
  output logic [$clog2(Depth):0] held_o
);
  localparam int Pointer = $clog2(Depth);

  // One bit more than an index: equal pointers are empty, pointers a depth apart full.
  logic [Pointer:0] write_d, write_q, read_d, read_q;
  logic [Width-1:0] entry_q [Depth];
  logic             write, read;

  assign held_o  = write_q - read_q;
  assign ready_o = held_o != (Pointer + 1)'(Depth);
  assign valid_o = held_o != '0;
  assign write   = valid_i && ready_o;
  assign read    = valid_o && ready_i;
  assign write_d = write_q + (Pointer + 1)'(write);
  assign read_d  = read_q + (Pointer + 1)'(read);
  assign data_o  = entry_q[read_q[Pointer-1:0]];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      write_q <= '0;
      read_q  <= '0;
    end else begin
      write_q <= write_d;
      read_q  <= read_d;
    end
  end

  // No reset: an entry is seen only after it was written.
  always_ff @(posedge clk_i) begin
    if (write) entry_q[write_q[Pointer-1:0]] <= data_i;
  end

`ifdef FORMAL
  // Proved by induction (hw/formal/run): a count kept apart agrees with the pointers and never leaves its range,
  // and one entry, any, comes out as it went in, after as many others as were there before it.
  logic [Pointer+1:0] count_q = '0;
  logic               watched_q = 1'b0;
  logic [Width-1:0]   value_q;
  logic [Pointer+1:0] ahead_q;
  (* anyseq *) logic  watch;
  initial begin
    write_q = '0;
    read_q  = '0;
  end
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q   <= '0;
      watched_q <= 1'b0;
    end else begin
      count_q <= count_q + (Pointer + 2)'(write) - (Pointer + 2)'(read);
      if (!watched_q && watch && write) begin
        watched_q <= 1'b1;
        value_q   <= data_i;
        ahead_q   <= count_q - (Pointer + 2)'(read);
      end else if (watched_q && read) begin
        watched_q <= ahead_q != '0;
        ahead_q   <= ahead_q - 1'b1;
      end
    end
  end
  always_comb begin
    assert (count_q == (Pointer + 2)'(held_o));
    assert (count_q <= Depth);
    assert (!(write && count_q == Depth) && !(read && count_q == '0));
    if (watched_q) begin
      assert (ahead_q < count_q);
      assert (entry_q[read_q[Pointer-1:0] + ahead_q[Pointer-1:0]] == value_q);
    end
    if (watched_q && ahead_q == '0) assert (valid_o && data_o == value_q);
  end
`endif
endmodule : fragment_fifo
