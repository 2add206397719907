#include "import/gltf/file/accessors.h"

#include <algorithm>
#include <cmath>

#include "import/input/load_bytes.h"

namespace tessera::client::gltf {
namespace {

/// Elements that may be zero because there are no bytes for them.
constexpr std::size_t kMostWithoutData = std::size_t{1} << 22;

std::size_t size_of_component(Component component) {
  switch (component) {
    case Component::kByte:
    case Component::kUnsignedByte:
      return 1;
    case Component::kShort:
    case Component::kUnsignedShort:
      return 2;
    case Component::kUnsignedInt:
    case Component::kFloat:
      return 4;
  }
  return 4;
}

const char* name_of(Component component) {
  switch (component) {
    case Component::kByte:
      return "i8";
    case Component::kUnsignedByte:
      return "u8";
    case Component::kShort:
      return "i16";
    case Component::kUnsignedShort:
      return "u16";
    case Component::kUnsignedInt:
      return "u32";
    case Component::kFloat:
      return "f32";
  }
  return "";
}

int components_of(const std::string& type) {
  if (type == "SCALAR") return 1;
  const int n = type.back() - '0';
  return type.starts_with("VEC") ? n : n * n;
}

/// Where the components of an element are: columns of matrices begin at multiples of four bytes.
std::size_t offset_of(const Accessor& accessor, int component) {
  const std::size_t size = size_of_component(accessor.component);
  const int side = accessor.components == 9 ? 3 : accessor.components == 16 ? 4 : 0;
  // MAT2 has as many components as VEC4, and differs in bytes alone, which nobody has.
  if (side == 0) return static_cast<std::size_t>(component) * size;
  const std::size_t column = (static_cast<std::size_t>(side) * size + 3) / 4 * 4;
  return static_cast<std::size_t>(component / side) * column +
         static_cast<std::size_t>(component % side) * size;
}

std::size_t size_of_element(const Accessor& accessor) {
  return offset_of(accessor, accessor.components - 1) + size_of_component(accessor.component);
}

double load(Component component, std::string_view bytes, std::size_t at) {
  switch (component) {
    case Component::kByte:
      return load_bytes<std::int8_t>(bytes, at);
    case Component::kUnsignedByte:
      return load_bytes<std::uint8_t>(bytes, at);
    case Component::kShort:
      return load_bytes<std::int16_t>(bytes, at);
    case Component::kUnsignedShort:
      return load_bytes<std::uint16_t>(bytes, at);
    case Component::kUnsignedInt:
      return load_bytes<std::uint32_t>(bytes, at);
    case Component::kFloat:
      return load_bytes<float>(bytes, at);
  }
  return 0;
}

double scale_of(const Accessor& accessor) {
  if (!accessor.normalized) return 1;
  switch (accessor.component) {
    case Component::kByte:
      return 1.0 / 127;
    case Component::kUnsignedByte:
      return 1.0 / 255;
    case Component::kShort:
      return 1.0 / 32767;
    case Component::kUnsignedShort:
      return 1.0 / 65535;
    default:
      return 1;
  }
}

}  // namespace

std::size_t Accessor::component_size() const { return size_of_component(component); }

AccessorTable::AccessorTable(Context& context, BufferTable& buffers) : context_(context), buffers_(buffers) {
  const std::size_t count = size_of(&context.document, "accessors");
  accessors_.resize(count);
  for (std::size_t i = 0; i < count && !context.diagnostics.full(); ++i) check(i);
}

void AccessorTable::check(std::size_t index) {
  const Json& json = *element(&context_.document, "accessors", index);
  const std::string place = below("/accessors", index);
  Accessor& accessor = accessors_[index];
  accessor.count = size_member(json, "count");
  accessor.components = components_of(text_of(&json, "type"));
  accessor.component = static_cast<Component>(integer_of(&json, "componentType", 5126));
  accessor.normalized = flag_of(&json, "normalized", false);
  accessor.format =
      concat(text_of(&json, "type"), " ", name_of(accessor.component), accessor.normalized ? "n" : "");
  if (accessor.normalized &&
      (accessor.component == Component::kFloat || accessor.component == Component::kUnsignedInt))
    context_.error(below(place, "normalized"), "only integers of 8 and 16 bits can be normalized");
  for (const char* name : {"min", "max"}) {
    const std::size_t size = size_of(&json, name);
    if (size != 0 && size != static_cast<std::size_t>(accessor.components))
      context_.error(below(place, name), concat("expected ", accessor.components, " elements, found ", size));
  }
  if (const std::optional<std::size_t> view = index_of(&json, "bufferView")) {
    check_span(*view, size_member(json, "byteOffset"), accessor.count, size_of_element(accessor),
               size_of_component(accessor.component), place);
  } else if (accessor.count > kMostWithoutData) {
    context_.error(below(place, "count"),
                   concat(accessor.count, " elements without data: more than ", kMostWithoutData));
  } else if (member(&json, "byteOffset") != nullptr) {
    context_.error(below(place, "byteOffset"), "an offset without a bufferView");
  }
  constexpr std::size_t kColumn = 4;
  if (text_of(&json, "type").starts_with("MAT") && size_member(json, "byteOffset") % kColumn != 0)
    context_.error(below(place, "byteOffset"), "a matrix does not begin at a multiple of four bytes");
  if (const Json* sparse = member(&json, "sparse")) check_sparse(*sparse, accessor, below(place, "sparse"));
}

void AccessorTable::check_sparse(const Json& sparse, const Accessor& accessor, const std::string& place) {
  const std::size_t count = size_member(sparse, "count");
  if (count > accessor.count)
    context_.error(below(place, "count"), concat(count, " replaced elements of ", accessor.count));
  const Json &indices = *member(&sparse, "indices"), &values = *member(&sparse, "values");
  const std::size_t index_size =
      size_of_component(static_cast<Component>(integer_of(&indices, "componentType", 5125)));
  check_span(*index_of(&indices, "bufferView"), size_member(indices, "byteOffset"), count, index_size,
             index_size, below(place, "indices"));
  check_span(*index_of(&values, "bufferView"), size_member(values, "byteOffset"), count,
             size_of_element(accessor), size_of_component(accessor.component), below(place, "values"));
}

bool AccessorTable::check_span(std::size_t view, std::size_t offset, std::size_t count,
                               std::size_t element_size, std::size_t component, const std::string& place) {
  const Json& json = *element(&context_.document, "bufferViews", view);
  const std::size_t all = size_member(json, "byteLength");
  const std::size_t own = buffers_.stride(view), stride = own == 0 ? element_size : own;
  if (stride < element_size) {
    context_.error(place, concat("elements of ", element_size, " bytes, ", stride, " bytes apart"));
    return false;
  }
  if (offset % component != 0 || (size_member(json, "byteOffset") + offset) % component != 0 ||
      (own != 0 && own % component != 0)) {
    context_.error(place, concat("its components of ", component, " bytes do not lie at multiples of that"));
    return false;
  }
  if (offset <= all && element_size <= all - offset && (count - 1) <= (all - offset - element_size) / stride)
    return true;
  context_.error(place, concat(count, " elements of ", element_size, " bytes from byte ", offset,
                               " on are more than its view of ", all, " bytes holds"));
  return false;
}

bool AccessorTable::visit(std::size_t index, absl::FunctionRef<void(std::size_t, int, double)> put) {
  const Json& json = *element(&context_.document, "accessors", index);
  const Accessor& accessor = accessors_[index];
  const std::string place = below("/accessors", index);
  if (!context_.spend(accessor.count, place)) return false;
  const auto put_element = [&](std::size_t i, std::string_view bytes, std::size_t at) {
    for (int c = 0; c < accessor.components; ++c)
      put(i, c, load(accessor.component, bytes, at + offset_of(accessor, c)));
  };
  if (const std::optional<std::size_t> view = index_of(&json, "bufferView")) {
    const std::optional<std::string_view> bytes = buffers_.view(*view);
    if (!bytes) return false;
    const std::size_t own = buffers_.stride(*view), stride = own == 0 ? size_of_element(accessor) : own;
    const std::size_t offset = size_member(json, "byteOffset");
    for (std::size_t i = 0; i < accessor.count; ++i) put_element(i, *bytes, offset + i * stride);
  }
  const Json* sparse = member(&json, "sparse");
  if (sparse == nullptr) return true;
  const Json &indices = *member(sparse, "indices"), &values = *member(sparse, "values");
  const auto index_bytes = buffers_.view(*index_of(&indices, "bufferView"));
  const auto value_bytes = buffers_.view(*index_of(&values, "bufferView"));
  if (!index_bytes || !value_bytes) return false;
  const auto type = static_cast<Component>(integer_of(&indices, "componentType", 5125));
  double last = -1;
  for (std::size_t i = 0; i < size_member(*sparse, "count"); ++i) {
    const double at =
        load(type, *index_bytes, size_member(indices, "byteOffset") + i * size_of_component(type));
    if (at <= last || at >= static_cast<double>(accessor.count)) {
      context_.error(below(below(place, "sparse"), "indices"),
                     concat("index ", at, " at ", i, ": they have to ascend, below ", accessor.count));
      return false;
    }
    last = at;
    put_element(static_cast<std::size_t>(at), *value_bytes,
                size_member(values, "byteOffset") + i * size_of_element(accessor));
  }
  return true;
}

std::optional<std::vector<float>> AccessorTable::read(std::size_t index) {
  const Accessor& accessor = accessors_[index];
  const double scale = scale_of(accessor);
  std::vector<float> numbers(accessor.count * static_cast<std::size_t>(accessor.components), 0.0f);
  std::size_t bad = numbers.size();
  const bool sound = visit(index, [&](std::size_t i, int c, double value) {
    const std::size_t at = i * static_cast<std::size_t>(accessor.components) + static_cast<std::size_t>(c);
    if (!std::isfinite(value)) bad = std::min(bad, i);
    numbers[at] = static_cast<float>(accessor.normalized ? std::max(value * scale, -1.0) : value);
  });
  if (!sound) return std::nullopt;
  if (bad < numbers.size()) {
    context_.error(below("/accessors", index), concat("element ", bad, " is not finite"));
    return std::nullopt;
  }
  return numbers;
}

std::optional<std::vector<std::uint32_t>> AccessorTable::read_integers(std::size_t index) {
  const Accessor& accessor = accessors_[index];
  std::vector<std::uint32_t> numbers(accessor.count * static_cast<std::size_t>(accessor.components), 0);
  const bool sound = visit(index, [&](std::size_t i, int c, double value) {
    numbers[i * static_cast<std::size_t>(accessor.components) + static_cast<std::size_t>(c)] =
        static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
  });
  return sound ? std::optional(std::move(numbers)) : std::nullopt;
}

}  // namespace tessera::client::gltf
