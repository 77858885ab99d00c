// A digest of the lerps of all 2^24 inputs of 8 bits: FNV-1a over the answers.
#include "Vlerp.h"
#include "trace.h"

int main(int argc, char** argv) {
  Vlerp unit(&tb::context(argc, argv));
  uint64_t digest = 0xcbf29ce484222325ull;
  for (uint32_t input = 0; input < 1u << 24; input++) {
    unit.a_i = input >> 16;
    unit.b_i = input >> 8 & 255;
    unit.fraction_i = input & 255;
    unit.eval();
    digest = (digest ^ unit.value_o) * 0x100000001b3ull;
  }
  std::printf("%016llx\n", static_cast<unsigned long long>(digest));
}
