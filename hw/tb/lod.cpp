// lod.sv against its trace.
#include "Vlod.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vlod unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "lod");
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    unit.scale_i = line["scale"];
    unit.explicit_i = line["explicit"];
    unit.bias_i = line["bias"];
    unit.min_lod_i = line["min_lod"];
    unit.max_lod_i = line["max_lod"];
    unit.last_i = line["last"];
    unit.level_rounding_i = line["level_rounding"];
    unit.eval();
    line.expect("raw", unit.raw_o & 0xffff);
    line.expect("clamped", unit.clamped_o);
    line.expect("fractional", unit.fractional_o);
    line.expect("whole", unit.whole_o);
  }
  std::printf("PASS lod %zu vectors\n", trace.lines());
}
