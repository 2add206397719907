// Results of workers, which the coordinator and the client decode.
#include "wire/tile_result.h"

#include "fuzz/target.h"

namespace tessera::fuzz {
namespace {

bool accepts_tile_result(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  const auto result = wire::decode_tile_result({input.data(), input.size()}, /*max_pixels=*/1 << 12);
  if (!result.ok()) {
    require(!result.status().message().empty(), "an error without a message");
    return false;
  }
  require(result->pixel_count() <= 1 << 12 && result->counts.size() == result->pixel_count() &&
              result->values.size() == result->pixel_count() * result->channels.size(),
          "a tile result of the wrong size");
  const auto again = wire::decode_tile_result(wire::encode_tile_result(*result));
  require(again.ok() && again->counts == result->counts && again->channels == result->channels,
          "a tile result does not survive encoding");
  return true;
}

}  // namespace

const Target kTileResult = {"tile_result", accepts_tile_result};

}  // namespace tessera::fuzz
