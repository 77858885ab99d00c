// memory.sv against its trace, clock by clock.
#include "Vmemory.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vmemory unit(&tb::context(argc, argv));
  tb::Trace trace(tb::trace_path(argc, argv), "memory");
  size_t compared = 0;
  for (size_t i = 0; i < trace.lines(); i++) {
    auto line = trace[i];
    unit.enable_i = line["enable"];
    unit.fill_i = line["fill"];
    unit.slot_i = line["slot"];
    unit.texel_i = line["word"];
    for (uint32_t texel = 0; texel < 16; texel++) unit.line_i[texel] = line["seed"] + texel * 0x9e3779b1u;
    tb::settle(unit);
    tb::tick(unit);
    if (line["known"]) {
      line.expect("texel", unit.texel_o);
      compared++;
    }
  }
  std::printf("PASS memory %zu clocks %zu texels\n", trace.lines(), compared);
}
