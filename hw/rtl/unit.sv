// The texture unit: requests in, texels out, lines of texture memory asked for on the way. It wires
//
//   lod -> taps -> surface | address | cache -> fragment_fifo -> memory | datapath
//                                       \-> memory request        ^- memory response
//
// with one register (|) between stages: one texel a clock from the tap unit on. Tags are looked up
// ahead of the data (Igehy, Eldridge & Proudfoot 1998): a miss is asked for when its tag is missed
// and waited for when it leaves the FIFO, so that hits and misses behind it go on.
//
// A texture is bound while the unit is idle; its sampler stays until the next. The clock-by-clock
// behaviour is in docs/hardware.md.
module unit #(
  parameter int Log2              = tex_pkg::Log2,
  parameter int LodBits           = tex_pkg::LodBits,
  parameter int FilterBits        = tex_pkg::FilterBits,
  parameter int Rounding          = tex_pkg::Rounding,
  parameter int TileLog2Width     = tex_pkg::TileLog2Width,
  parameter int TileLog2Height    = tex_pkg::TileLog2Height,
  parameter int Sets              = tex_pkg::Sets,
  parameter int Ways              = tex_pkg::Ways,
  parameter int FragmentFifoDepth = tex_pkg::FragmentFifoDepth,
  // Derived.
  parameter int LineBits          = tex_pkg::AddressBits - tex_pkg::LineLog2Bytes,
  parameter int LineWidth         = 8 << tex_pkg::LineLog2Bytes
) (
  input  logic                            clk_i,
  input  logic                            rst_ni,
  // Bind a sampler and a texture; every line in the cache is forgotten.
  input  logic                            bind_valid_i,
  output logic                            bind_ready_o,
  input  logic [2:0]                      filter_i,
  input  logic [1:0]                      mode_u_i,
  input  logic [1:0]                      mode_v_i,
  input  logic                            explicit_i,
  input  logic [1:0]                      level_rounding_i,
  input  logic signed [13:0]              bias_i,
  input  logic [13:0]                     min_lod_i,
  input  logic [13:0]                     max_lod_i,
  input  logic                            tiled_i,
  input  logic [tex_pkg::LevelBits-1:0]   log2_width_i,
  input  logic [tex_pkg::LevelBits-1:0]   log2_height_i,
  // Requests.
  input  logic                            request_valid_i,
  output logic                            request_ready_o,
  input  logic [31:0]                     u_i,
  input  logic [31:0]                     v_i,
  input  logic [31:0]                     scale_u_i,
  input  logic [31:0]                     scale_v_i,
  // Responses, in the order of the requests.
  output logic                            response_valid_o,
  input  logic                            response_ready_i,
  output logic [31:0]                     texel_o,
  output logic [15:0]                     lod_u_o,
  output logic [15:0]                     lod_v_o,
  // Texture memory: line numbers out, lines in, in the same order.
  output logic                            memory_request_valid_o,
  input  logic                            memory_request_ready_i,
  output logic [LineBits-1:0]             memory_request_line_o,
  input  logic                            memory_response_valid_i,
  output logic                            memory_response_ready_o,
  input  logic [LineWidth-1:0]            memory_response_data_i,
  // Every look-up, in the clock in which it counts: for traces.
  output logic                            access_valid_o,
  output logic                            access_hit_o,
  output logic [tex_pkg::AddressBits-1:0] access_address_o,
  // Counters since reset.
  output logic [31:0]                     requests_o,
  output logic [31:0]                     lookups_o,
  output logic [31:0]                     misses_o,
  // Clocks in which a texel waited for the FIFO, for the memory's request port, for a line.
  output logic [31:0]                     fifo_stalls_o,
  output logic [31:0]                     request_stalls_o,
  output logic [31:0]                     line_stalls_o
);
  localparam int Level    = tex_pkg::LevelBits;
  localparam int Address  = tex_pkg::AddressBits;
  localparam int Lod      = Level + 8;
  localparam int SetBits  = $clog2(Sets);
  localparam int WayBits  = Ways > 1 ? $clog2(Ways) : 1;
  localparam int SlotBits = $clog2(Sets * Ways);
  localparam int WordBits = tex_pkg::LineLog2Bytes - 2;

  // ------------------------------------------------------------------------------------ binding
  logic bound_q, bind_accept, surface_busy, idle;
  logic [2:0]         filter_q;
  logic [1:0]         mode_u_q, mode_v_q, level_rounding_q;
  logic               explicit_q, tiled_q, start_q;
  logic signed [13:0] bias_q;
  logic [13:0]        min_lod_q, max_lod_q;
  logic [Level-1:0]   log2_width_q, log2_height_q;

  assign bind_ready_o = idle && !surface_busy && !start_q;
  assign bind_accept  = bind_valid_i && bind_ready_o;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      bound_q          <= 1'b0;
      start_q          <= 1'b0;
      filter_q         <= tex_pkg::FilterPoint;
      mode_u_q         <= tex_pkg::AddressWrap;
      mode_v_q         <= tex_pkg::AddressWrap;
      explicit_q       <= 1'b0;
      level_rounding_q <= tex_pkg::LevelFloor;
      bias_q           <= '0;
      min_lod_q        <= '0;
      max_lod_q        <= '0;
      tiled_q          <= 1'b0;
      log2_width_q     <= '0;
      log2_height_q    <= '0;
    end else begin
      start_q <= bind_accept;
      if (bind_accept) begin
        bound_q          <= 1'b1;
        filter_q         <= filter_i;
        mode_u_q         <= mode_u_i;
        mode_v_q         <= mode_v_i;
        explicit_q       <= explicit_i;
        level_rounding_q <= level_rounding_i;
        bias_q           <= bias_i;
        min_lod_q        <= min_lod_i;
        max_lod_q        <= max_lod_i;
        tiled_q          <= tiled_i;
        log2_width_q     <= log2_width_i;
        log2_height_q    <= log2_height_i;
      end
    end
  end

  // ---------------------------------------------------------------------------- levels and taps
  logic             dipmap;
  logic [Level-1:0] chain_last, last_first;
  assign dipmap     = filter_q == tex_pkg::FilterDipmap;
  assign chain_last = log2_width_q > log2_height_q ? log2_width_q : log2_height_q;
  assign last_first = dipmap ? log2_width_q : chain_last;

  logic [Lod-1:0]   clamped_u, clamped_v, fractional;
  logic [Level-1:0] whole;
  logic signed [15:0] unused_raw_u, unused_raw_v;
  logic [Lod-1:0]     unused_fractional_v;
  logic [Level-1:0]   unused_whole_v;
  logic [15:0]        unused_clamped;
  lod #(.Log2(Log2), .LodBits(LodBits)) u_lod_u (
    .scale_i(scale_u_i), .explicit_i(explicit_q), .bias_i(bias_q), .min_lod_i(min_lod_q),
    .max_lod_i(max_lod_q), .last_i(last_first), .level_rounding_i(level_rounding_q),
    .raw_o(unused_raw_u), .clamped_o(clamped_u), .fractional_o(fractional), .whole_o(whole)
  );
  lod #(.Log2(Log2), .LodBits(LodBits)) u_lod_v (
    .scale_i(scale_v_i), .explicit_i(explicit_q), .bias_i(bias_q), .min_lod_i(min_lod_q),
    .max_lod_i(max_lod_q), .last_i(log2_height_q), .level_rounding_i(level_rounding_q),
    .raw_o(unused_raw_v), .clamped_o(clamped_v), .fractional_o(unused_fractional_v), .whole_o(unused_whole_v)
  );
  assign unused_clamped = {clamped_u[7:0], clamped_v[7:0]};

  logic                          taps_valid, taps_in_ready, taps_ready, request_accept, running;
  logic [tex_pkg::PlaneBits-1:0] plane;
  logic [8:0]                    weight;
  logic [1:0]                    corner;
  logic                          point, tap_end, request_end;
  logic [Lod-1:0]                lod_u, lod_v;
  logic [31:0]                   u_q, v_q;
  assign running         = bound_q && !surface_busy && !start_q;
  assign request_ready_o = taps_in_ready && running;
  assign request_accept  = request_valid_i && request_ready_o;
  taps u_taps (
    .clk_i, .rst_ni, .filter_i(filter_q), .last_i(chain_last), .last_u_i(log2_width_q),
    .valid_i(request_valid_i && running), .ready_o(taps_in_ready),
    .fractional_i(fractional), .whole_i(whole), .level_u_i(clamped_u[Lod-1:8]), .level_v_i(clamped_v[Lod-1:8]),
    .valid_o(taps_valid), .ready_i(taps_ready), .plane_o(plane), .weight_o(weight), .corner_o(corner),
    .point_o(point), .tap_end_o(tap_end), .request_end_o(request_end), .lod_u_o(lod_u), .lod_v_o(lod_v)
  );
  logic unused_tap_end;
  assign unused_tap_end = tap_end;
  always_ff @(posedge clk_i) begin
    if (request_accept) begin
      u_q <= u_i;
      v_q <= v_i;
    end
  end

  // --------------------------------------------------------------------------------- plane table
  logic [Address-1:0] base;
  logic [Level-1:0]   plane_log2_width, plane_log2_height;
  surface #(.TileLog2Width(TileLog2Width), .TileLog2Height(TileLog2Height)) u_surface (
    .clk_i, .rst_ni, .start_i(start_q), .dipmap_i(dipmap), .tiled_i(tiled_q),
    .log2_width_i(log2_width_q), .log2_height_i(log2_height_q), .busy_o(surface_busy),
    .plane_i(plane), .base_o(base), .log2_width_o(plane_log2_width), .log2_height_o(plane_log2_height)
  );

  // Register: a texel with its plane.
  localparam int PassBits = 9 + 2 + 1 + 1 + 2 * Lod;
  logic                plane_valid_q, plane_ready;
  logic [31:0]         plane_u_q, plane_v_q;
  logic [Address-1:0]  plane_base_q;
  logic [Level-1:0]    plane_log2_width_q, plane_log2_height_q;
  logic [PassBits-1:0] plane_pass_q;
  assign taps_ready = !plane_valid_q || plane_ready;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) plane_valid_q <= 1'b0;
    else if (taps_ready) plane_valid_q <= taps_valid;
  end
  always_ff @(posedge clk_i) begin
    if (taps_ready) begin
      plane_u_q           <= u_q;
      plane_v_q           <= v_q;
      plane_base_q        <= base;
      plane_log2_width_q  <= plane_log2_width;
      plane_log2_height_q <= plane_log2_height;
      plane_pass_q        <= {weight, corner, point, request_end, lod_u, lod_v};
    end
  end

  // ------------------------------------------------------------------------------------- address
  logic [Address-1:0]    texel_address;
  logic                  texel_outside;
  logic [FilterBits-1:0] fraction_u, fraction_v;
  address #(
    .FilterBits(FilterBits), .TileLog2Width(TileLog2Width), .TileLog2Height(TileLog2Height)
  ) u_address (
    .u_i(plane_u_q), .v_i(plane_v_q), .base_i(plane_base_q), .log2_width_i(plane_log2_width_q),
    .log2_height_i(plane_log2_height_q), .mode_u_i(mode_u_q), .mode_v_i(mode_v_q), .tiled_i(tiled_q),
    .point_i(plane_pass_q[2*Lod+1]), .corner_i(plane_pass_q[2*Lod+2 +: 2]),
    .address_o(texel_address), .outside_o(texel_outside), .fraction_u_o(fraction_u), .fraction_v_o(fraction_v)
  );

  // Register: a texel with its address.
  logic                  address_valid_q, address_ready, address_outside_q;
  logic [Address-1:0]    address_q;
  logic [FilterBits-1:0] address_fraction_u_q, address_fraction_v_q;
  logic [PassBits-1:0]   address_pass_q;
  assign plane_ready = !address_valid_q || address_ready;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) address_valid_q <= 1'b0;
    else if (plane_ready) address_valid_q <= plane_valid_q;
  end
  always_ff @(posedge clk_i) begin
    if (plane_ready) begin
      address_q            <= texel_address;
      address_outside_q    <= texel_outside;
      address_fraction_u_q <= fraction_u;
      address_fraction_v_q <= fraction_v;
      address_pass_q       <= plane_pass_q;
    end
  end

  // ---------------------------------------------------------------------------------------- tags
  localparam int EntryBits = SlotBits + WordBits + 2 + 2 * FilterBits + PassBits;
  logic                 hit, miss, fifo_ready, entry_write;
  logic [WayBits-1:0]   way;
  logic [SetBits-1:0]   set;
  logic [SlotBits-1:0]  slot;
  logic [EntryBits-1:0] entry_in, entry;
  cache #(.Sets(Sets), .Ways(Ways)) u_cache (
    .clk_i, .rst_ni, .flush_i(bind_accept), .line_i(address_q[Address-1:tex_pkg::LineLog2Bytes]),
    .update_i(access_valid_o), .hit_o(hit), .way_o(way), .set_o(set)
  );
  if (Ways > 1) begin : gen_ways
    assign slot = {set, way};
  end else begin : gen_one_way
    assign slot = set;
    logic unused_way;
    assign unused_way = way;
  end
  assign miss                   = !address_outside_q && !hit;
  assign memory_request_valid_o = address_valid_q && miss && fifo_ready;
  assign memory_request_line_o  = address_q[Address-1:tex_pkg::LineLog2Bytes];
  assign address_ready          = fifo_ready && (!miss || memory_request_ready_i);
  assign entry_write            = address_valid_q && address_ready;
  assign access_valid_o         = entry_write && !address_outside_q;
  assign access_hit_o           = hit;
  assign access_address_o       = address_q;
  assign entry_in = {slot, address_q[2 +: WordBits], miss, address_outside_q, address_fraction_u_q,
                     address_fraction_v_q, address_pass_q};

  logic fifo_valid, bank_enable;
  logic [$clog2(FragmentFifoDepth):0] unused_held;
  fragment_fifo #(.Width(EntryBits), .Depth(FragmentFifoDepth)) u_fragment_fifo (
    .clk_i, .rst_ni, .valid_i(entry_write), .ready_o(fifo_ready), .data_i(entry_in),
    .valid_o(fifo_valid), .ready_i(bank_enable), .data_o(entry), .held_o(unused_held)
  );

  // ---------------------------------------------------------------------------------- data banks
  logic [SlotBits-1:0]   entry_slot;
  logic [WordBits-1:0]   entry_word;
  logic                  entry_miss, entry_outside;
  logic [FilterBits-1:0] entry_fraction_u, entry_fraction_v;
  logic [PassBits-1:0]   entry_pass;
  assign {entry_slot, entry_word, entry_miss, entry_outside, entry_fraction_u, entry_fraction_v, entry_pass} = entry;

  logic                  bank_valid_q, bank_outside_q, bank_ready, data_ready;
  logic [FilterBits-1:0] bank_fraction_u_q, bank_fraction_v_q;
  logic [PassBits-1:0]   bank_pass_q;
  logic [31:0]           bank_texel;
  assign bank_ready              = !bank_valid_q || data_ready;
  assign memory_response_ready_o = fifo_valid && entry_miss && bank_ready;
  assign bank_enable             = bank_ready && fifo_valid && (!entry_miss || memory_response_valid_i);
  memory #(.Slots(Sets * Ways), .Texels(1 << WordBits)) u_memory (
    .clk_i, .enable_i(bank_enable), .fill_i(entry_miss), .slot_i(entry_slot), .line_i(memory_response_data_i),
    .texel_i(entry_word), .texel_o(bank_texel)
  );
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) bank_valid_q <= 1'b0;
    else if (bank_ready) bank_valid_q <= bank_enable;
  end
  always_ff @(posedge clk_i) begin
    if (bank_enable) begin
      bank_outside_q    <= entry_outside;
      bank_fraction_u_q <= entry_fraction_u;
      bank_fraction_v_q <= entry_fraction_v;
      bank_pass_q       <= entry_pass;
    end
  end

  // ------------------------------------------------------------------------------------ datapath
  logic [8:0]       bank_weight;
  logic [1:0]       bank_corner;
  logic             bank_point, bank_end;
  logic [2*Lod-1:0] bank_lods, response_lods;
  assign {bank_weight, bank_corner, bank_point, bank_end, bank_lods} = bank_pass_q;
  datapath #(.FilterBits(FilterBits), .Rounding(Rounding), .TagBits(2 * Lod)) u_datapath (
    .clk_i, .rst_ni, .valid_i(bank_valid_q), .ready_o(data_ready),
    .texel_i(bank_outside_q ? 32'd0 : bank_texel), .corner_i(bank_corner), .point_i(bank_point),
    .request_end_i(bank_end), .fraction_u_i(bank_fraction_u_q), .fraction_v_i(bank_fraction_v_q),
    .weight_i(bank_weight), .tag_i(bank_lods), .valid_o(response_valid_o), .ready_i(response_ready_i),
    .texel_o, .tag_o(response_lods)
  );
  assign lod_u_o = 16'(response_lods[2*Lod-1:Lod]);
  assign lod_v_o = 16'(response_lods[Lod-1:0]);

  // ------------------------------------------------------------------- requests inside, counters
  logic [15:0] inside_q;
  logic        response_taken;
  assign response_taken = response_valid_o && response_ready_i;
  // A request offered in the same clock goes first: it must not be answered by the next sampler.
  assign idle           = inside_q == '0 && !request_accept;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      inside_q         <= '0;
      requests_o       <= '0;
      lookups_o        <= '0;
      misses_o         <= '0;
      fifo_stalls_o    <= '0;
      request_stalls_o <= '0;
      line_stalls_o    <= '0;
    end else begin
      inside_q         <= inside_q + 16'(request_accept) - 16'(response_taken);
      requests_o       <= requests_o + 32'(request_accept);
      lookups_o        <= lookups_o + 32'(access_valid_o);
      misses_o         <= misses_o + 32'(access_valid_o && !hit);
      fifo_stalls_o    <= fifo_stalls_o + 32'(address_valid_q && !fifo_ready);
      request_stalls_o <= request_stalls_o + 32'(memory_request_valid_o && !memory_request_ready_i);
      line_stalls_o    <= line_stalls_o + 32'(memory_response_ready_o && !memory_response_valid_i);
    end
  end
endmodule : unit
