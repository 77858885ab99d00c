// The datapath: weighted sums of four 8-bit channels (docs/numerics.md, section 6). Texels arrive one
// a clock in the order (i0, j0), (i1, j0), (i0, j1), (i1, j1); a point tap is one texel.
//
// Four stages: lerp along u, lerp along v, weigh and add, round. As texels arrive singly, one lerp
// a direction and channel is enough. Weights of a request sum to 256. A response that is not
// taken stops all four stages.
module datapath #(
  // Bits of the bilinear fraction, 1 to 12.
  parameter int FilterBits = tex_pkg::FilterBits,
  // RoundOnce, RoundStaged or RoundStagedTruncate.
  parameter int Rounding   = tex_pkg::Rounding,
  // Bits that pass from the last texel of a request to its response.
  parameter int TagBits    = 1
) (
  input  logic                  clk_i,
  input  logic                  rst_ni,
  input  logic                  valid_i,
  output logic                  ready_o,
  // Red in the lowest byte.
  input  logic [31:0]           texel_i,
  input  logic [1:0]            corner_i,
  input  logic                  point_i,
  input  logic                  request_end_i,
  input  logic [FilterBits-1:0] fraction_u_i,
  input  logic [FilterBits-1:0] fraction_v_i,
  input  logic [8:0]            weight_i,
  input  logic [TagBits-1:0]    tag_i,
  output logic                  valid_o,
  input  logic                  ready_i,
  output logic [31:0]           texel_o,
  output logic [TagBits-1:0]    tag_o
);
  localparam bit Once       = Rounding == tex_pkg::RoundOnce;
  localparam int RowWidth   = Once ? 8 + FilterBits : 8;
  localparam int ValueWidth = Once ? 8 + 2 * FilterBits : 8;
  localparam int SumWidth   = ValueWidth + 8;
  localparam int Shift      = SumWidth - 8;

  logic advance;
  assign advance = !valid_o || ready_i;
  assign ready_o = advance;

  // What goes along with a row, a value and a sum.
  logic                  row_valid_q, row_lower_q, row_point_q, row_end_q;
  logic [FilterBits-1:0] row_fraction_q;
  logic [8:0]            row_weight_q, value_weight_q;
  logic                  value_valid_q, value_end_q, sum_end_q, sum_open_q, response_valid_q;
  logic [TagBits-1:0]    row_tag_q, value_tag_q, sum_tag_q, response_tag_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      row_valid_q      <= 1'b0;
      value_valid_q    <= 1'b0;
      sum_end_q        <= 1'b0;
      sum_open_q       <= 1'b0;
      response_valid_q <= 1'b0;
    end else if (advance) begin
      row_valid_q   <= valid_i && (point_i || corner_i[0]);
      value_valid_q <= row_valid_q && (row_point_q || row_lower_q);
      sum_end_q     <= value_valid_q && value_end_q;
      // A sum is open between the first tap of a request and the last.
      if (value_valid_q) sum_open_q <= !value_end_q;
      response_valid_q <= sum_end_q;
    end
  end

  // No reset: read only where a valid bit above says so.
  always_ff @(posedge clk_i) begin
    if (advance) begin
      row_lower_q    <= corner_i[1];
      row_point_q    <= point_i;
      row_end_q      <= request_end_i;
      row_fraction_q <= fraction_v_i;
      row_weight_q   <= weight_i;
      row_tag_q      <= tag_i;
      value_weight_q <= row_weight_q;
      value_end_q    <= row_end_q;
      value_tag_q    <= row_tag_q;
      sum_tag_q      <= value_tag_q;
      response_tag_q <= sum_tag_q;
    end
  end

  for (genvar channel = 0; channel < 4; channel++) begin : gen_channel
    logic [7:0]            texel, left_q, left;
    logic [RowWidth-1:0]   row, row_q, top_q, top;
    logic [ValueWidth-1:0] value, value_q;
    logic [SumWidth-1:0]   sum_q, rounded;
    logic [7:0]            response_q;

    assign texel = texel_i[8*channel +: 8];
    // A point tap is its own left and top neighbour.
    assign left = point_i ? texel : left_q;
    assign top  = row_point_q ? row_q : top_q;
    lerp #(.Width(8), .FractionBits(FilterBits), .Rounding(Rounding)) u_row (
      .a_i(left), .b_i(texel), .fraction_i(fraction_u_i), .value_o(row)
    );
    lerp #(.Width(RowWidth), .FractionBits(FilterBits), .Rounding(Rounding)) u_column (
      .a_i(top), .b_i(row_q), .fraction_i(row_fraction_q), .value_o(value)
    );
    assign rounded = sum_q
        + (Rounding == tex_pkg::RoundStagedTruncate ? SumWidth'(0) : SumWidth'(1) << (Shift - 1));

    always_ff @(posedge clk_i) begin
      if (advance) begin
        if (valid_i && !corner_i[0]) left_q <= texel;
        row_q <= row;
        if (row_valid_q) top_q <= row_q;
        value_q <= value;
        if (value_valid_q) begin
          sum_q <= (sum_open_q ? sum_q : '0) + SumWidth'(value_q) * SumWidth'(value_weight_q);
        end
        response_q <= rounded[Shift +: 8];
      end
    end
    assign texel_o[8*channel +: 8] = response_q;
    logic [Shift-1:0] unused_rounded;
    assign unused_rounded = rounded[Shift-1:0];
  end

  assign valid_o = response_valid_q;
  assign tag_o   = response_tag_q;
endmodule : datapath
