// address.sv against its trace.
#include "Vaddress.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vaddress unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "address");
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    unit.u_i = line["u"];
    unit.v_i = line["v"];
    unit.base_i = line["base"];
    unit.log2_width_i = line["log2_width"];
    unit.log2_height_i = line["log2_height"];
    unit.mode_u_i = line["mode_u"];
    unit.mode_v_i = line["mode_v"];
    unit.tiled_i = line["tiled"];
    unit.point_i = line["point"];
    unit.corner_i = line["corner"];
    unit.eval();
    line.expect("outside", unit.outside_o);
    if (!unit.outside_o) line.expect("address", unit.address_o);
    line.expect("fraction_u", unit.fraction_u_o);
    line.expect("fraction_v", unit.fraction_v_o);
  }
  std::printf("PASS address %zu vectors\n", trace.lines());
}
