// cache.sv against its trace, clock by clock.
#include "Vcache.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vcache unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "cache");
  unit.rst_ni = 1;
  unit.update_i = unit.flush_i = 0;
  size_t hits = 0, updates = 0;
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    tb::settle(unit);
    unit.rst_ni = !line["reset"];
    unit.flush_i = line["flush"];
    unit.update_i = line["update"];
    unit.line_i = line["line"];
    tb::settle(unit);
    line.expect("hit", unit.hit_o);
    line.expect("way", unit.way_o);
    hits += unit.hit_o;
    updates += unit.update_i;
    tb::tick(unit);
  }
  std::printf("PASS cache %zu clocks %zu updates %zu hits\n", trace.lines(), updates, hits);
}
