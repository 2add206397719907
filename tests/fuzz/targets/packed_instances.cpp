#include "wire/packed_instances.h"

#include <cmath>
#include <cstring>

#include "fuzz/target.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::fuzz {
namespace {

bool accepts_packed_instances(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  // Runs as the header claims them, so that mutations come to the matrices.
  std::uint64_t count = 0;
  if (input.size() >= 16) std::memcpy(&count, input.data() + 8, sizeof(count));
  v1::PackedInstances packed;
  for (const std::uint64_t part : {count / 2, count - count / 2}) packed.add_runs()->set_count(part);
  const auto matrices = wire::decode_matrices(packed, {input.data(), input.size()});
  if (!matrices.ok()) return false;
  require(matrices->size() == count * wire::kPackedElements, "matrices that the runs have not");
  double sum = 0;
  for (const double x : *matrices) sum += std::abs(x);  // reads all that the view promises
  require(std::isfinite(sum), "a number that is not finite");
  return true;
}

}  // namespace

const Target kPackedInstances = {"packed_instances", accepts_packed_instances};

}  // namespace tessera::fuzz
