#include "import/spectra/named_spectra.h"

#include "import/spectra/photometry.h"
#include "import/spectra/tables.h"

namespace tessera::client {
namespace {

bool consume_prefix(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

bool consume_suffix(std::string_view& text, std::string_view suffix) {
  if (!text.ends_with(suffix)) return false;
  text.remove_suffix(suffix.size());
  return true;
}

std::optional<SpectrumTable> unit_luminance(std::optional<SpectrumTable> table) {
  if (!table) return table;
  const float scale = static_cast<float>(1 / luminance(*table));
  for (float& value : table->values) value *= scale;
  return table;
}

}  // namespace

SpectrumTable uniform_table(float first_nm, float step_nm, std::span<const float> values) {
  SpectrumTable table;
  table.values.assign(values.begin(), values.end());
  for (std::size_t i = 0; i < values.size(); ++i) {
    table.wavelengths_nm.push_back(first_nm + step_nm * static_cast<float>(i));
  }
  return table;
}

std::optional<SpectrumTable> find_named_spectrum(std::string_view name) {
  if (consume_prefix(name, "metal-")) {
    if (consume_suffix(name, "-eta")) return find_metal(name, false);
    if (consume_suffix(name, "-k")) return find_metal(name, true);
    return std::nullopt;
  }
  if (consume_prefix(name, "glass-")) return find_glass(name);
  if (consume_prefix(name, "stdillum-")) {
    return name == "acesD60" ? std::nullopt : unit_luminance(find_illuminant(name));
  }
  if (name == "illum-acesD60") return unit_luminance(find_illuminant("acesD60"));
  return std::nullopt;
}

}  // namespace tessera::client
