#include "wire/packed_instances.h"

#include <bit>
#include <cassert>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "wire/scene_numbers.h"

namespace tessera::wire {
namespace {

static_assert(std::endian::native == std::endian::little, "blobs are used in place");

constexpr std::string_view kInstanceMagic = "TSRINST1";
constexpr std::size_t kInstanceHeaderBytes = 16;
constexpr std::uint64_t kMostPacked = std::uint64_t{1} << 31;

absl::Status unsound_instances(const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("packed instances: ", what));
}

}  // namespace

std::string encode_matrices(std::vector<std::vector<double>> groups) {
  std::uint64_t numbers = 0;
  for (const std::vector<double>& group : groups) numbers += group.size();
  assert(numbers % kPackedElements == 0);
  const std::uint64_t count = numbers / kPackedElements;
  std::string blob;
  blob.reserve(kInstanceHeaderBytes + numbers * sizeof(double));
  blob += kInstanceMagic;
  blob.append(reinterpret_cast<const char*>(&count), sizeof(count));
  for (std::vector<double>& group : groups) {
    blob.append(reinterpret_cast<const char*>(group.data()), group.size() * sizeof(double));
    std::vector<double>().swap(group);
  }
  return blob;
}

bool is_matrices(std::string_view blob) { return blob.starts_with(kInstanceMagic); }

absl::StatusOr<std::span<const double>> decode_matrices(const v1::PackedInstances& packed,
                                                        std::string_view blob) {
  if (reinterpret_cast<std::uintptr_t>(blob.data()) % sizeof(double) != 0)
    return unsound_instances("the bytes are not 8-byte aligned");
  if (blob.size() < kInstanceHeaderBytes)
    return unsound_instances(absl::StrCat(blob.size(), " bytes are too few for the header"));
  if (!is_matrices(blob)) return unsound_instances("bad magic number");
  std::uint64_t count;
  std::memcpy(&count, blob.data() + kInstanceMagic.size(), sizeof(count));
  if (count > kMostPacked) return unsound_instances(absl::StrCat(count, " of them are more than 2^31"));
  const std::uint64_t bytes = kInstanceHeaderBytes + count * kPackedElements * sizeof(double);
  if (bytes != blob.size()) {
    return unsound_instances(
        absl::StrCat(count, " of them take ", bytes, " bytes, but there are ", blob.size()));
  }
  std::uint64_t left = count;
  for (const v1::PackedInstances::Run& run : packed.runs()) {
    if (run.count() > left) return unsound_instances(absl::StrCat("the runs have more than ", count));
    left -= run.count();
  }
  if (left > 0) return unsound_instances(absl::StrCat("the runs have ", left, " less than ", count));
  const std::span numbers(reinterpret_cast<const double*>(blob.data() + kInstanceHeaderBytes),
                          count * kPackedElements);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!is_scene_number(numbers[i])) {
      return unsound_instances(absl::StrCat("matrix ", i / kPackedElements, " has ", numbers[i],
                                            ", which is not ", kSceneNumberRange));
    }
  }
  return numbers;
}

}  // namespace tessera::wire
