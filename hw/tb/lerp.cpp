// lerp.sv against its trace, or `--sweep`: a digest of all 2^24 inputs of a lerp of 8-bit values.
#include <cstring>

#include "Vlerp.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vlerp unit(&tb::context(argc, argv));
  if (argc == 2 && !std::strcmp(argv[1], "--sweep")) {
    uint64_t digest = 0;
    for (uint32_t input = 0; input < 1u << 24; input++) {
      unit.a_i = input >> 16;
      unit.b_i = input >> 8 & 255;
      unit.fraction_i = input & 255;
      unit.eval();
      digest = digest * 0x100000001b3ull + unit.value_o;
    }
    std::printf("%016llx\n", static_cast<unsigned long long>(digest));
    return 0;
  }
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
