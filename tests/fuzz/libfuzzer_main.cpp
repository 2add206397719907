// libFuzzer's entry, compiled once for each target (TESSERA_FUZZ_TARGET).
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "fuzz/target.h"

namespace {
const tessera::fuzz::Target& kTarget = tessera::fuzz::TESSERA_FUZZ_TARGET;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  kTarget.accepts({reinterpret_cast<const char*>(data), size});
  return 0;
}

/// A target's own mutations, where it has some, in turn with libFuzzer's.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (kTarget.mutate == nullptr || seed % 4 == 0) return LLVMFuzzerMutate(data, size, max_size);
  std::mt19937 random(seed);
  const std::string mutated = kTarget.mutate({reinterpret_cast<const char*>(data), size}, random);
  if (mutated.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memcpy(data, mutated.data(), mutated.size());
  return mutated.size();
}
