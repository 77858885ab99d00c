// surface.sv against its trace: start, wait for the walk to end, look every plane up.
#include "Vsurface.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vsurface unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "surface");
  unit.start_i = 0;
  tb::reset(unit);
  size_t looked = 0;
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    unit.start_i = line["op"] == 1;
    unit.dipmap_i = line["dipmap"];
    unit.tiled_i = line["tiled"];
    unit.log2_width_i = line["log2_width"];
    unit.log2_height_i = line["log2_height"];
    unit.plane_i = line["plane"];
    if (line["op"] == 3) {
      tb::reset(unit);
      line.expect("busy after reset", 0, unit.busy_o);
      continue;
    }
    tb::settle(unit);
    if (line["op"] == 2) {
      uint64_t clocks = 0;
      while (unit.busy_o && clocks < 100) {
        tb::tick(unit);
        tb::settle(unit);
        clocks++;
      }
      if (clocks) line.expect("clocks", clocks);
      if (line["plane"] == 0) line.expect("walked", 1, clocks > 0);
      line.expect("base", unit.base_o);
      line.expect("plane_log2_width", unit.log2_width_o);
      line.expect("plane_log2_height", unit.log2_height_o);
      looked++;
    }
    tb::tick(unit);
  }
  std::printf("PASS surface %zu lines %zu look-ups\n", trace.lines(), looked);
}
