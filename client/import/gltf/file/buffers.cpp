#include "import/gltf/file/buffers.h"

#include <meshoptimizer.h>

#include "import/gltf/file/container.h"

namespace tessera::client::gltf {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr std::int64_t kElementArray = 34963;  // bufferView.target of indices
/// Growth of compressed data that is let through: streams of zeros, the best case of the codec, grow about
/// 250-fold.
constexpr std::size_t kMostGrowth = 1024;

const Json& entry(const Context& context, const char* array, std::size_t index) {
  return *element(&context.document, array, index);
}

/// The codecs abort (assertions) where element sizes are not theirs.
std::string check_meshopt_form(const Json& compressed) {
  const std::string mode = text_of(&compressed, "mode"), filter = text_of(&compressed, "filter", "NONE");
  const std::size_t stride = size_member(compressed, "byteStride"), count = size_member(compressed, "count");
  if (mode == "ATTRIBUTES" && stride % 4 != 0) return "the stride of attributes is not a multiple of 4";
  if (mode != "ATTRIBUTES" && stride != 2 && stride != 4) return "the stride of indices is neither 2 nor 4";
  if (mode == "TRIANGLES" && count % 3 != 0)
    return "the count of indices of triangles is not a multiple of 3";
  if (mode != "ATTRIBUTES" && filter != "NONE") return "a filter of indices";
  if (filter == "OCTAHEDRAL" && stride != 4 && stride != 8)
    return "the filter OCTAHEDRAL needs a stride of 4 or 8";
  if (filter == "QUATERNION" && stride != 8) return "the filter QUATERNION needs a stride of 8";
  return "";
}

}  // namespace

absl::StatusOr<InputFile> open_regular(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error))
    return absl::InvalidArgumentError(concat(path.string(), ": not a regular file"));
  return InputFile::open(path);
}

BufferTable::BufferTable(Context& context) : context_(context) {
  const std::size_t buffers = size_of(&context.document, "buffers"),
                    views = size_of(&context.document, "bufferViews");
  buffers_.resize(buffers);
  files_.resize(buffers);
  decoded_.resize(buffers);
  for (std::size_t i = 0; i < buffers && !context.diagnostics.full(); ++i) open(i);
  for (std::size_t i = 0; i < views && !context.diagnostics.full(); ++i) check_view(i);
}

void BufferTable::open(std::size_t index) {
  const Json& buffer = entry(context_, "buffers", index);
  const std::string place = below("/buffers", index);
  const std::size_t size = size_member(buffer, "byteLength");
  const Json* uri_member = member(&buffer, "uri");
  std::string_view bytes;
  if (uri_member == nullptr) {
    if (index > 0 || context_.glb_binary_chunk.empty()) {
      return;  // check_view() reports it where a view needs its bytes; a compressed one does not
    }
    bytes = context_.glb_binary_chunk;
  } else if (const auto& uri = uri_member->get_ref<const std::string&>(); is_data_uri(uri)) {
    absl::StatusOr<std::string> decoded = decode_data_uri(uri);
    if (!decoded.ok()) {
      context_.error(below(place, "uri"), std::string(decoded.status().message()));
      return;
    }
    if (const std::string_view type = std::string_view(uri).substr(5, uri.find_first_of(";,") - 5);
        type != "application/octet-stream" && type != "application/gltf-buffer")
      context_.error(below(place, "uri"),
                     concat("a buffer of the type \"", std::string(type),
                            "\", not application/octet-stream or application/gltf-buffer"));
    bytes = decoded_[index] = *std::move(decoded);
    if (bytes.size() > size)
      context_.error(below(place, "byteLength"),
                     concat("the buffer is to have ", size, " bytes, but its data URI has ", bytes.size()));
  } else {
    const absl::StatusOr<std::filesystem::path> path = file_of_uri(context_.folder, uri);
    absl::StatusOr<InputFile> file = path.ok() ? open_regular(*path) : path.status();
    if (!file.ok()) {
      context_.error(below(place, "uri"), std::string(file.status().message()));
      return;
    }
    files_[index] = *std::move(file);
    bytes = files_[index].bytes();
  }
  if (bytes.size() < size) {
    context_.error(below(place, "byteLength"),
                   concat("the buffer is to have ", size, " bytes, but there are ", bytes.size()));
    return;
  }
  buffers_[index] = bytes.substr(0, size);
}

std::optional<std::string_view> BufferTable::part(const Json& from, const std::string& place) {
  const std::size_t buffer = *index_of(&from, "buffer");
  const std::size_t all = size_member(entry(context_, "buffers", buffer), "byteLength");
  const std::size_t offset = size_member(from, "byteOffset"), size = size_member(from, "byteLength");
  if (offset > all || size > all - offset) {
    context_.error(place, concat("bytes ", offset, " to ", offset + size, " of a buffer of ", all));
    return std::nullopt;
  }
  if (!buffers_[buffer]) return std::nullopt;
  return buffers_[buffer]->substr(offset, size);
}

void BufferTable::check_view(std::size_t index) {
  const Json& view = entry(context_, "bufferViews", index);
  const std::string place = below("/bufferViews", index);
  const bool is_there = buffers_[*index_of(&view, "buffer")].has_value();
  part(view, place);
  const std::size_t apart = size_member(view, "byteStride");
  if (apart % 4 != 0)
    context_.error(below(place, "byteStride"),
                   concat("a stride of ", apart, ", which is not a multiple of 4"));
  if (apart > size_member(view, "byteLength"))
    context_.error(below(place, "byteStride"), concat("a stride of ", apart, " is more than the view has"));
  if (apart != 0 && integer_of(&view, "target", 0) == kElementArray)
    context_.error(below(place, "byteStride"), "a view of indices has no stride");
  const Json* compressed = extension(&view, kMeshopt);
  if (compressed == nullptr && !is_there)
    context_.error(below(place, "buffer"),
                   "a buffer without uri, which only the first of a .glb with a binary chunk may be");
  if (compressed == nullptr) return;
  const std::string at = below(below(place, "extensions"), kMeshopt);
  part(*compressed, at);
  if (const std::string fault = check_meshopt_form(*compressed); !fault.empty()) context_.error(at, fault);
  const std::size_t size = size_member(view, "byteLength"), count = size_member(*compressed, "count"),
                    stride = size_member(*compressed, "byteStride");
  if (count > size / stride || count * stride != size)
    context_.error(at, concat(count, " elements of ", stride, " bytes do not make the view's ", size));
  const std::size_t from = size_member(*compressed, "byteLength");
  if (size / kMostGrowth > from + 64)
    context_.error(at,
                   concat(from, " bytes that are to become ", size, ": more than ", kMostGrowth, "-fold"));
}

std::optional<std::string_view> BufferTable::view(std::size_t index) {
  const Json& view = entry(context_, "bufferViews", index);
  const std::string place = below("/bufferViews", index);
  const Json* compressed = extension(&view, kMeshopt);
  if (compressed == nullptr) {
    if (!buffers_[*index_of(&view, "buffer")]) {
      context_.error(place, "its buffer has no data");
      return std::nullopt;
    }
    return part(view, place);
  }
  const auto [known, is_new] = decompressed_.try_emplace(index);
  if (is_new) known->second = decompress(*compressed, below(below(place, "extensions"), kMeshopt));
  if (!known->second) return std::nullopt;
  return std::string_view(*known->second);
}

std::size_t BufferTable::stride(std::size_t index) const {
  const Json& view = entry(context_, "bufferViews", index);
  const Json* compressed = extension(&view, kMeshopt);
  return size_member(compressed != nullptr ? *compressed : view, "byteStride");
}

std::optional<std::string> BufferTable::decompress(const Json& compressed, const std::string& place) {
  const std::optional<std::string_view> from = part(compressed, place);
  if (!from) return std::nullopt;
  const std::size_t stride = size_member(compressed, "byteStride"), count = size_member(compressed, "count");
  const std::string mode = text_of(&compressed, "mode"), filter = text_of(&compressed, "filter", "NONE");
  std::string result(count * stride, '\0');
  const auto* bytes = reinterpret_cast<const unsigned char*>(from->data());
  const int fault =
      mode == "ATTRIBUTES"  ? meshopt_decodeVertexBuffer(result.data(), count, stride, bytes, from->size())
      : mode == "TRIANGLES" ? meshopt_decodeIndexBuffer(result.data(), count, stride, bytes, from->size())
                            : meshopt_decodeIndexSequence(result.data(), count, stride, bytes, from->size());
  if (fault != 0) {
    context_.error(place, concat("the compressed data are damaged (meshoptimizer's error ", fault, ")"));
    return std::nullopt;
  }
  if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(result.data(), count, stride);
  if (filter == "QUATERNION") meshopt_decodeFilterQuat(result.data(), count, stride);
  if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(result.data(), count, stride);
  return result;
}

}  // namespace tessera::client::gltf
