// The whole unit against its trace: every texel and level, every hit and miss, under the trace's pauses
// and stalls and a memory that hesitates; or `--clocks LATENCY`: no pauses, a memory that answers after
// LATENCY clocks, and the clocks from the first request of each texture to its last response.
#include <cstring>
#include <deque>

#include "Vunit.h"
#include "trace.h"

namespace {

uint32_t word_at(uint32_t word) {
  uint32_t h = word * 0x9e3779b1u;
  h = (h ^ h >> 15) * 0x85ebca77u;
  return h ^ h >> 13;
}

// Texture memory: lines in the order they are asked for.
struct Memory {
  struct Line {
    uint64_t due;
    uint32_t number;
  };
  std::deque<Line> lines;
  uint64_t latency = 0;  // 0: hesitate
  uint32_t noise = 1;

  bool chance(unsigned of_16) {
    noise = noise * 1664525u + 1013904223u;
    return (noise >> 28) < of_16;
  }
};

}  // namespace

int main(int argc, char** argv) {
  Vunit unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "unit");
  bool timing = argc == 4 && !std::strcmp(argv[2], "--clocks");
  Memory memory;
  if (timing) memory.latency = std::atoi(argv[3]);

  std::deque<size_t> wanted;
  struct Access {
    size_t item;
    bool hit;
  };
  std::deque<Access> accesses;
  uint64_t now = 0, stall = 0, first = 0, last = 0;
  uint64_t responses = 0, seen_accesses = 0, misses = 0, resets = 0;
  uint64_t since_reset_requests = 0, since_reset_lookups = 0, since_reset_misses = 0;

  struct Taken {
    bool bind, request;
  };
  auto clock = [&] {
    unit.response_ready_i = timing || stall == 0;
    if (stall) stall--;
    unit.memory_request_ready_i = timing || memory.chance(11);
    bool there = !memory.lines.empty() && memory.lines.front().due <= now && (timing || memory.chance(9));
    unit.memory_response_valid_i = there;
    for (uint32_t texel = 0; texel < 16; texel++)
      unit.memory_response_data_i[texel] = there ? word_at(memory.lines.front().number * 16 + texel) : 0xdeadbeef;
    tb::settle(unit);
    if (unit.memory_response_ready_o && there) memory.lines.pop_front();
    // A line is asked for when a look-up misses, and at no other time.
    bool asked = unit.memory_request_valid_o && unit.memory_request_ready_i;
    if (asked != (unit.access_valid_o && !unit.access_hit_o)) tb::fail("unit: a line asked for without a miss");
    if (unit.memory_request_valid_o && unit.memory_request_ready_i) {
      uint64_t delay = timing ? memory.latency : 1 + memory.chance(8) * 20;
      memory.lines.push_back({now + delay, static_cast<uint32_t>(unit.memory_request_line_o)});
    }
    if (unit.access_valid_o) {
      if (accesses.empty()) tb::fail("unit: a look-up that nobody asked for");
      trace[accesses.front().item].expect("hit", accesses.front().hit, unit.access_hit_o);
      misses += !accesses.front().hit;
      since_reset_misses += !accesses.front().hit;
      accesses.pop_front();
      seen_accesses++;
      since_reset_lookups++;
    }
    if (unit.response_valid_o) {
      if (wanted.empty()) tb::fail("unit: a response that nobody asked for");
      auto line = trace[wanted.front()];
      line.expect("texel", unit.texel_o);
      line.expect("lod_u", unit.lod_u_o);
      line.expect("lod_v", unit.lod_v_o);
      if (unit.response_ready_i) {
        wanted.pop_front();
        responses++;
        last = now;
      }
    }
    Taken taken = {unit.bind_valid_i && unit.bind_ready_o, unit.request_valid_i && unit.request_ready_o};
    tb::tick(unit);
    now++;
    return taken;
  };
  auto quiet = [&] {
    unit.bind_valid_i = unit.request_valid_i = 0;
    unsigned waited = 0;
    while (!wanted.empty()) {
      if (++waited > 20000) tb::fail("unit: a response is missing");
      clock();
    }
    if (!accesses.empty()) tb::fail("unit: a look-up is missing");
    // The counters agree with what was seen.
    if (unit.requests_o != since_reset_requests || unit.lookups_o != since_reset_lookups ||
        unit.misses_o != since_reset_misses)
      tb::fail("unit: a counter is wrong");
  };
  unsigned segment = 0;
  bool open = false;
  auto close = [&] {
    if (timing && open) {
      quiet();
      std::printf("clocks %u %llu\n", segment++, static_cast<unsigned long long>(last - first + 1));
    }
    open = false;
  };

  unit.bind_valid_i = unit.request_valid_i = unit.response_ready_i = 0;
  unit.memory_request_ready_i = unit.memory_response_valid_i = 0;
  tb::reset(unit);
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    unit.bind_valid_i = unit.request_valid_i = 0;
    if (line["op"] == 2) {
      close();
      // Whatever is inside, asked of memory included, is lost.
      wanted.clear();
      accesses.clear();
      memory.lines.clear();
      stall = 0;
      since_reset_requests = since_reset_lookups = since_reset_misses = 0;
      tb::reset(unit);
      resets++;
      continue;
    }
    if (!timing)
      for (uint64_t idle = 0; idle < line["idle"]; idle++) clock();
    if (line["op"] == 1) {
      close();
      uint64_t choices = line["u"];
      unit.filter_i = choices >> 28;
      unit.mode_u_i = choices >> 24 & 15;
      unit.mode_v_i = choices >> 20 & 15;
      unit.explicit_i = choices >> 16 & 15;
      unit.level_rounding_i = choices >> 12 & 15;
      unit.tiled_i = choices >> 8 & 15;
      unit.log2_width_i = choices >> 4 & 15;
      unit.log2_height_i = choices & 15;
      unit.bias_i = line["v"];
      unit.min_lod_i = line["scale_u"] >> 16;
      unit.max_lod_i = line["scale_u"] & 0xffff;
      unit.bind_valid_i = 1;
      while (!clock().bind) {
      }
      // The binding is the unit's now.
      unit.filter_i = ~unit.filter_i & 7;
      unit.log2_width_i = ~unit.log2_width_i & 15;
      if (timing) {
        unit.bind_valid_i = 0;
        for (unsigned walk = 0; walk < 40; walk++) clock();
      }
    } else {
      unit.u_i = line["u"];
      unit.v_i = line["v"];
      unit.scale_u_i = line["scale_u"];
      unit.scale_v_i = line["scale_v"];
      unit.request_valid_i = 1;
      while (!clock().request) {
      }
      if (!open) first = now - 1;
      open = true;
      since_reset_requests++;
      wanted.push_back(i);
      for (uint64_t access = 0; access < line["accesses"]; access++)
        accesses.push_back({i, (line["hits"] >> access & 1) != 0});
      stall = line["stall"];
    }
  }
  close();
  quiet();
  std::printf("PASS unit %zu lines %llu responses %llu look-ups %llu misses %llu resets %llu clocks\n", trace.lines(),
              static_cast<unsigned long long>(responses), static_cast<unsigned long long>(seen_accesses),
              static_cast<unsigned long long>(misses), static_cast<unsigned long long>(resets),
              static_cast<unsigned long long>(now));
}
