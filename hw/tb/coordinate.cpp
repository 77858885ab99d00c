// coordinate.sv against its trace.
#include "Vcoordinate.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vcoordinate unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "coordinate");
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    unit.coordinate_i = line["coordinate"];
    unit.log2_size_i = line["log2_size"];
    unit.mode_i = line["mode"];
    unit.point_i = line["point"];
    unit.upper_i = line["upper"];
    unit.eval();
    line.expect("outside", unit.outside_o);
    if (!unit.outside_o) line.expect("index", unit.index_o);
    line.expect("fraction", unit.fraction_o);
  }
  std::printf("PASS coordinate %zu vectors\n", trace.lines());
}
