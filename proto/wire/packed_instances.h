// The bytes of PackedInstances.matrices. Little endian, so that a mapped file can be used in place:
//
//   0   char[8]    magic "TSRINST1"
//   8   u64        count N (at most 2^31)
//   16  f64[12 N]  of each matrix the upper three rows, row by row; the fourth is 0 0 0 1
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::v1 {
class PackedInstances;
}

namespace tessera::wire {

/// Numbers of a matrix in the blob.
inline constexpr std::size_t kPackedElements = 12;

/// The blob of matrices; frees each group when it is in the blob.
std::string encode_matrices(std::vector<std::vector<double>> groups);

/// Whether `blob` has the mark of such a blob.
bool is_matrices(std::string_view blob);

/// The numbers in `blob`, whose data must be 8-byte aligned. InvalidArgument, with what is wrong, for a bad
/// magic, a size that does not fit the count, a number that no scene may hold, or runs of other length.
absl::StatusOr<std::span<const double>> decode_matrices(const v1::PackedInstances& packed,
                                                        std::string_view blob);

}  // namespace tessera::wire
