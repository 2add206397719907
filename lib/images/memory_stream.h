// Bytes in memory as a file of OpenEXR's C++ library.
#pragma once

#include <OpenEXR/ImfIO.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace tessera::images {

/// Throws std::runtime_error where the bytes end.
class MemoryStream final : public Imf::IStream {
 public:
  explicit MemoryStream(std::string_view bytes) : Imf::IStream("image"), bytes_(bytes) {}

  bool read(char to[], int count) override {
    if (count < 0 || static_cast<std::uint64_t>(count) > bytes_.size() - at_)
      throw std::runtime_error("the file ends early");
    std::memcpy(to, bytes_.data() + at_, static_cast<std::size_t>(count));
    at_ += static_cast<std::uint64_t>(count);
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t to) override {
    if (to > bytes_.size()) throw std::runtime_error("the file ends early");
    at_ = to;
  }

 private:
  const std::string_view bytes_;
  std::uint64_t at_ = 0;
};

}  // namespace tessera::images
