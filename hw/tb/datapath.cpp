// datapath.sv against its trace: texels with pauses in, responses with stalls out, resets with texels inside.
#include <deque>

#include "Vdatapath.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vdatapath unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "datapath");
  unit.valid_i = unit.ready_i = 0;
  tb::reset(unit);
  std::deque<size_t> wanted;
  uint64_t stall = 0;
  size_t responses = 0, resets = 0, clocks = 0;
  auto clock = [&] {
    unit.ready_i = stall == 0;
    if (stall) stall--;
    tb::settle(unit);
    bool taken = unit.valid_i && unit.ready_o;
    if (unit.valid_o) {
      if (wanted.empty()) tb::fail("datapath: a response that nobody asked for");
      // Held while it is not taken, so compared in every clock.
      auto line = trace[wanted.front()];
      line.expect("texel", unit.texel_o);
      line.expect("tag", wanted.front() & 1, unit.tag_o);
      if (unit.ready_i) {
        wanted.pop_front();
        responses++;
      }
    }
    tb::tick(unit);
    clocks++;
    return taken;
  };
  static const char* const texels[2][4] = {{"t00", "t01", "t02", "t03"}, {"t10", "t11", "t12", "t13"}};
  // The first `count` texels of a request; pauses lie between them as well.
  auto send = [&](size_t i, unsigned count) {
    auto line = trace[i];
    unsigned corners = line["point"] ? 1 : 4, all = line["taps"] * corners;
    for (unsigned texel = 0; texel < count; texel++) {
      unsigned tap = texel / corners, corner = texel % corners;
      bool end = texel + 1 == all;
      unit.valid_i = 0;
      for (uint64_t pause = 0; pause < line["idle"] >> corner; pause++) clock();
      unit.valid_i = 1;
      unit.texel_i = line[texels[tap][corner]];
      unit.corner_i = corner;
      unit.point_i = line["point"];
      unit.request_end_i = end;
      unit.fraction_u_i = line[tap ? "fraction_u1" : "fraction_u0"];
      unit.fraction_v_i = line[tap ? "fraction_v1" : "fraction_v0"];
      unit.weight_i = line[tap ? "weight_1" : "weight_0"];
      // Only the last texel's counts.
      unit.tag_i = (i & 1) ^ !end;
      while (!clock()) {
      }
      if (end) wanted.push_back(i);
    }
    unit.valid_i = 0;
  };
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    if (line["reset"]) {
      // With responses on their way and all but the last texel of a request inside.
      send(i, line["taps"] * (line["point"] ? 1 : 4) - 1);
      resets++;
      wanted.clear();
      stall = 0;
      tb::reset(unit);
    }
    send(i, line["taps"] * (line["point"] ? 1 : 4));
    stall = line["stall"];
  }
  for (unsigned wait = 0; !wanted.empty(); wait++) {
    if (wait > 100) tb::fail("datapath: a response is missing");
    clock();
  }
  std::printf("PASS datapath %zu requests %zu responses %zu resets %zu clocks\n", trace.lines(), responses, resets, clocks);
}
