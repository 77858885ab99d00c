// The cache tags: Sets x Ways lines under exact LRU. Tags only: lines live in memory.sv.
//
// Each way of a set has a rank, 0 for the line used last; the ranks of a set are always a permutation
// (proved in hw/formal). Empty ways start as the oldest, the lowest way first, so that no rule for
// empty ways is needed. A look-up answers in the same clock; it changes the order only if update_i.
module cache #(
  // Powers of two: at least 2 sets, at least 1 way.
  parameter int Sets     = tex_pkg::Sets,
  parameter int Ways     = tex_pkg::Ways,
  // Bits of a line number.
  parameter int LineBits = tex_pkg::AddressBits - tex_pkg::LineLog2Bytes,
  // Derived.
  parameter int WayBits  = Ways > 1 ? $clog2(Ways) : 1
) (
  input  logic                    clk_i,
  input  logic                    rst_ni,
  // Forget every line.
  input  logic                    flush_i,
  input  logic [LineBits-1:0]     line_i,
  input  logic                    update_i,
  output logic                    hit_o,
  // Where the line is, or where it goes.
  output logic [WayBits-1:0]      way_o,
  output logic [$clog2(Sets)-1:0] set_o
);
  localparam int SetBits = $clog2(Sets);
  localparam int TagBits = LineBits - SetBits;
  localparam int SlotBits = $clog2(Sets * Ways);

  logic [TagBits-1:0]      tag_q  [Sets*Ways];
  logic [WayBits*Ways-1:0] rank_q [Sets];
  logic [Sets*Ways-1:0]    valid_q;
  // Sets whose ranks were written since the last flush; the others are in their first order.
  logic [Sets-1:0]         used_q;

  logic [TagBits-1:0] tag;
  assign set_o = line_i[SetBits-1:0];
  assign tag   = line_i[LineBits-1:SetBits];

  // Way 0 of the set.
  logic [SlotBits-1:0] first;
  assign first = SlotBits'(set_o) << $clog2(Ways);

  // The ways of the set, side by side.
  logic [Ways-1:0]         match, oldest;
  logic [WayBits*Ways-1:0] rank, rank_first, rank_next;
  assign rank = used_q[set_o] ? rank_q[set_o] : rank_first;
  for (genvar way = 0; way < Ways; way++) begin : gen_way
    assign match[way] = valid_q[first | SlotBits'(way)] && tag_q[first | SlotBits'(way)] == tag;
    assign rank_first[way*WayBits +: WayBits] = WayBits'(Ways - 1 - way);
    assign oldest[way] = rank[way*WayBits +: WayBits] == WayBits'(Ways - 1);
    assign rank_next[way*WayBits +: WayBits] =
        way_o == WayBits'(way) ? '0
        : rank[way*WayBits +: WayBits] < used_rank ? rank[way*WayBits +: WayBits] + WayBits'(1)
        : rank[way*WayBits +: WayBits];
  end

  logic [Ways-1:0]    chosen;
  logic [WayBits-1:0] used_rank;
  assign hit_o  = |match;
  assign chosen = hit_o ? match : oldest;
  always_comb begin
    way_o     = '0;
    used_rank = '0;
    // One-hot: an OR is a multiplexer.
    for (int way = 0; way < Ways; way++) begin
      if (chosen[way]) begin
        way_o     = way_o | WayBits'(way);
        used_rank = used_rank | rank[way*WayBits +: WayBits];
      end
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_q <= '0;
      used_q  <= '0;
    end else if (flush_i) begin
      valid_q <= '0;
      used_q  <= '0;
    end else if (update_i) begin
      valid_q[first | SlotBits'(way_o)] <= 1'b1;
      used_q[set_o]                     <= 1'b1;
    end
  end

  // No reset: tags and ranks count only where valid_q and used_q say so.
  always_ff @(posedge clk_i) begin
    if (update_i) begin
      tag_q[first | SlotBits'(way_o)] <= tag;
      rank_q[set_o]                   <= rank_next;
    end
  end

`ifdef FORMAL
  // Proved by induction (hw/formal/run), for every set and clock.
  initial begin
    valid_q = '0;
    used_q  = '0;
  end
  for (genvar s = 0; s < Sets; s++) begin : gen_formal_set
    wire [WayBits*Ways-1:0] ranks = used_q[s] ? rank_q[s] : rank_first;
    for (genvar a = 0; a < Ways; a++) begin : gen_formal_a
      for (genvar b = 0; b < Ways; b++) begin : gen_formal_b
        if (a < b) begin : gen_formal_pair
          always_comb begin
            // The order is a permutation: ranks have exactly as many values as there are ways.
            assert (ranks[a*WayBits +: WayBits] != ranks[b*WayBits +: WayBits]);
            // No line is held twice.
            assert (!(valid_q[s*Ways+a] && valid_q[s*Ways+b]) || tag_q[s*Ways+a] != tag_q[s*Ways+b]);
          end
        end
        // Empty ways are older than all others, so they are filled first.
        always_comb assert (valid_q[s*Ways+a] || !valid_q[s*Ways+b]
                            || ranks[a*WayBits +: WayBits] > ranks[b*WayBits +: WayBits]);
      end
    end
  end
  // One way is chosen, and way_o is its number.
  always_comb begin
    assert ((chosen & (chosen - 1'b1)) == '0 && chosen != '0);
    assert (chosen[way_o]);
  end
`endif
endmodule : cache
