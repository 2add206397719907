// The bytes of buffers and buffer views.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "import/gltf/context.h"
#include "import/input/input_file.h"

namespace tessera::client::gltf {

/// A regular file; InvalidArgument for pipes and the like, which would have to be waited for.
absl::StatusOr<InputFile> open_regular(const std::filesystem::path& path);

class BufferTable {
 public:
  /// Opens all buffers and checks all views; what is wrong is reported.
  explicit BufferTable(Context& context);

  /// The bytes of a view, decompressed where that is needed. Nothing where something is wrong, which has been
  /// reported.
  std::optional<std::string_view> view(std::size_t index);
  /// 0 where elements follow one another closely.
  std::size_t stride(std::size_t index) const;

 private:
  void open(std::size_t index);
  void check_view(std::size_t index);
  std::optional<std::string_view> part(const Json& from, const std::string& place);
  std::optional<std::string> decompress(const Json& compressed, const std::string& place);

  Context& context_;
  std::vector<InputFile> files_;
  std::vector<std::string> decoded_;
  std::vector<std::optional<std::string_view>> buffers_;
  std::map<std::size_t, std::optional<std::string>> decompressed_;
};

}  // namespace tessera::client::gltf
