// FIRST LAST: for each block of 2^24 ratios a digest of raw_o, FNV-1a over pairs of answers.
#include "Vlod_sweep.h"
#include "trace.h"

int main(int argc, char** argv) {
  if (argc != 3) tb::fail("usage: FIRST LAST");
  Vlod_sweep unit(&tb::context(argc, argv));
  for (unsigned block = std::atoi(argv[1]); block <= static_cast<unsigned>(std::atoi(argv[2])); block++) {
    uint64_t digest = 0xcbf29ce484222325ull;
    for (uint32_t high = 0; high < 1u << 20; high++) {
      unit.high_i = block << 20 | high;
      unit.eval();
      for (int pair = 0; pair < 8; pair++) digest = (digest ^ unit.raw_o[pair]) * 0x100000001b3ull;
    }
    std::printf("%02x %016llx\n", block, static_cast<unsigned long long>(digest));
  }
}
