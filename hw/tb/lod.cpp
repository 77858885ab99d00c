// lod.sv against its trace, or `--sweep FIRST LAST`: for each block of 2^24 ratios a digest of raw_o.
#include <cstring>

#include "Vlod.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vlod unit(&tb::context(argc, argv));
  if (argc == 4 && !std::strcmp(argv[1], "--sweep")) {
    unit.explicit_i = unit.bias_i = unit.min_lod_i = unit.max_lod_i = unit.last_i = unit.level_rounding_i = 0;
    for (unsigned block = std::atoi(argv[2]); block <= static_cast<unsigned>(std::atoi(argv[3])); block++) {
      // Horner's rule modulo 2^64: every place and value counts.
      uint64_t digest = 0;
      for (uint32_t low = 0; low < 1u << 24; low++) {
        unit.scale_i = block << 24 | low;
        unit.eval();
        digest = digest * 0x100000001b3ull + (unit.raw_o & 0xffff);
      }
      std::printf("%02x %016llx\n", block, static_cast<unsigned long long>(digest));
    }
    return 0;
  }
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
