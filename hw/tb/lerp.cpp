// lerp.sv against its trace.
#include "Vlerp.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vlerp unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "lerp");
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    unit.a_i = line["a"];
    unit.b_i = line["b"];
    unit.fraction_i = line["fraction"];
    unit.eval();
    line.expect("value", unit.value_o);
  }
  std::printf("PASS lerp %zu vectors\n", trace.lines());
}
