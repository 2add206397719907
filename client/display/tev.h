// The viewer tev (https://github.com/Tom94/tev), which shows pictures that programs send it over TCP.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "display/growing_image.h"
#include "image/image.h"

namespace tessera::client {

/// Where tev listens unless told otherwise.
inline constexpr const char* kTevAddress = "127.0.0.1:14158";

/// Messages of tev's protocol, with their length in front: an image of three planes, R, G, B, and new pixels
/// for a part of it, plane by plane, rows from the top.
std::string tev_create_image(const std::string& name, std::int32_t width, std::int32_t height);
std::string tev_update_image(const std::string& name, const Window& part, const std::vector<float>& planes);

/// A connection to tev.
class Tev {
 public:
  /// Unavailable where nobody listens.
  static absl::StatusOr<Tev> connect(const std::string& address);
  Tev(Tev&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  ~Tev();

  /// Unavailable when tev is gone, or takes nothing for 5 s.
  absl::Status send(const std::string& message);

 private:
  explicit Tev(int socket) : socket_(socket) {}
  int socket_;
};

/// A picture in tev, of which results come in.
class TevPicture {
 public:
  /// Unavailable where nobody listens.
  static absl::StatusOr<TevPicture> open(const std::string& address, std::string name, const Window& crop);

  /// Sends what the result changed. InvalidArgument for a result that is not of this picture; Unavailable
  /// when tev is gone.
  absl::Status add(const wire::TileResult& result);
  /// All results come again.
  void clear() { image_.clear(); }

 private:
  TevPicture(Tev tev, std::string name, const Window& crop)
      : tev_(std::move(tev)), name_(std::move(name)), image_(crop, crop.width(), crop.height()) {}

  Tev tev_;
  std::string name_;
  GrowingImage image_;
};

}  // namespace tessera::client
