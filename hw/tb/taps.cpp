// taps.sv against its trace: requests with pauses in, texels with stalls out, resets with a request inside.
#include <deque>

#include "Vtaps.h"
#include "trace.h"

namespace {
struct Texel {
  size_t item;
  unsigned tap, corner;
};
}  // namespace

int main(int argc, char** argv) {
  Vtaps unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "taps");
  unit.valid_i = unit.ready_i = 0;
  tb::reset(unit);
  std::deque<Texel> wanted;
  uint64_t stall = 0, filter = ~0ull;
  size_t texels = 0, resets = 0, clocks = 0;
  auto clock = [&](bool& taken) {
    unit.ready_i = stall == 0;
    if (stall) stall--;
    tb::settle(unit);
    taken = unit.valid_i && unit.ready_o;
    if (wanted.empty() && unit.valid_o) tb::fail("taps: a texel that nobody asked for");
    if (!wanted.empty() && !unit.valid_o) tb::fail("taps: a texel is late");
    // The next request enters when nobody is inside, or with the last texel of the one that is.
    if (unit.ready_o != (!unit.valid_o || (unit.ready_i && unit.request_end_o))) tb::fail("taps: ready_o");
    if (unit.valid_o && unit.ready_i) {
      Texel texel = wanted.front();
      wanted.pop_front();
      auto line = trace[texel.item];
      bool point = line["filter"] == 0;
      bool last_corner = point || texel.corner == 3;
      line.expect(texel.tap ? "plane_1" : "plane_0", unit.plane_o);
      line.expect(texel.tap ? "weight_1" : "weight_0", unit.weight_o);
      line.expect("corner", texel.corner, unit.corner_o);
      line.expect("point", point, unit.point_o);
      line.expect("tap_end", last_corner, unit.tap_end_o);
      line.expect("request_end", last_corner && texel.tap + 1 == line["taps"], unit.request_end_o);
      line.expect("lod_u", unit.lod_u_o);
      line.expect("lod_v", unit.lod_v_o);
      texels++;
    }
    tb::tick(unit);
    clocks++;
  };
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    bool taken = false;
    unit.valid_i = 0;
    // The filter belongs to the sampler: it changes only when nobody is inside.
    while (line["filter"] != filter && !wanted.empty()) clock(taken);
    filter = line["filter"];
    unit.filter_i = filter;
    if (line["reset"]) {
      resets++;
      wanted.clear();
      stall = 0;
      tb::reset(unit);
    }
    for (uint64_t idle = 0; idle < line["idle"]; idle++) clock(taken);
    while (line["filter"] == filter && !wanted.empty() &&
           (line["last"] != unit.last_i || line["last_u"] != unit.last_u_i)) clock(taken);
    unit.last_i = line["last"];
    unit.last_u_i = line["last_u"];
    unit.fractional_i = line["fractional"];
    unit.whole_i = line["whole"];
    unit.level_u_i = line["level_u"];
    unit.level_v_i = line["level_v"];
    unit.valid_i = 1;
    for (taken = false; !taken;) clock(taken);
    for (unsigned tap = 0; tap < line["taps"]; tap++)
      for (unsigned corner = 0; corner < (filter == 0 ? 1 : 4); corner++) wanted.push_back({i, tap, corner});
    stall = line["stall"];
  }
  unit.valid_i = 0;
  for (bool taken; !wanted.empty();) clock(taken);
  std::printf("PASS taps %zu requests %zu texels %zu resets %zu clocks\n", trace.lines(), texels, resets, clocks);
}
