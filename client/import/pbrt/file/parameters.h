// The parameter list that follows most directives: "float radius" [ 1 ] "rgb L" [ 1 1 1 ] ...
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "import/geometry/transform.h"
#include "import/input/diagnostics.h"
#include "import/pbrt/file/color_space.h"

namespace tessera::client::pbrt {

enum class ParameterType : unsigned char {
  kInteger,
  kFloat,
  kPoint2,
  kVector2,
  kPoint3,
  kVector3,
  kNormal,
  kSpectrum,
  kRgb,
  kBlackbody,
  kBool,
  kString,
  kTexture
};

/// The type that a declaration names, or nothing.
std::optional<ParameterType> parameter_type_of(std::string_view name);
std::string_view name_of(ParameterType type);
/// How many numbers make one value: 3 for a point3; 0 where values are not numbers.
int numbers_per_value(ParameterType type);

struct Parameter {
  ParameterType type = ParameterType::kFloat;
  std::string name;
  SourceLocation where;
  std::vector<double> numbers;                 // bools are 0 and 1
  std::vector<std::string> strings;            // strings, textures, named spectra and spectrum files
  ColorSpace color_space = ColorSpace::kSrgb;  // space that its RGB values are in
  bool used = false;
};

/// The parameters of one directive, with the defaults of `Attribute` behind them. Wrong types and counts are
/// reported where the parameter stands. Copies count together what was asked for: when the last of them ends,
/// every parameter that nobody asked for is a warning, unless nobody looked at the list at all (a material of
/// no shape).
class ParameterList {
 public:
  ParameterList() = default;
  /// `owner` is what the parameters belong to, for messages: shape "sphere". `diagnostics` must outlive all
  /// copies.
  ParameterList(std::vector<Parameter> parameters, const std::vector<Parameter>& defaults, std::string owner,
                SourceLocation where, ColorSpace color_space, Diagnostics& diagnostics);

  const std::string& owner() const { return own_->owner; }
  SourceLocation where() const { return where_; }
  /// In force at the directive.
  ColorSpace color_space() const { return color_space_; }

  /// The parameter of that name, marked as used. A type that is not accepted is an error and gives null.
  const Parameter* find(std::string_view name, std::initializer_list<ParameterType> accepted,
                        Diagnostics& diagnostics);
  bool has(std::string_view name) const;

  double get_float(std::string_view name, double fallback, Diagnostics& diagnostics);
  std::int64_t get_integer(std::string_view name, std::int64_t fallback, Diagnostics& diagnostics);
  bool get_bool(std::string_view name, bool fallback, Diagnostics& diagnostics);
  std::string get_string(std::string_view name, const std::string& fallback, Diagnostics& diagnostics);
  Imath::V3d get_point(std::string_view name, const Imath::V3d& fallback, Diagnostics& diagnostics);

  /// Marks parameters that have no effect on the image, or whose effect has been warned of, so that they are
  /// not warned of.
  void ignore(std::initializer_list<std::string_view> names);

 private:
  std::optional<double> single_number(std::string_view name, ParameterType type, Diagnostics& diagnostics);

  /// State that the copies of a list share.
  struct Own {
    std::vector<Parameter> parameters;
    std::string owner;
    Diagnostics* diagnostics = nullptr;
    bool looked_at = false;

    Own() = default;
    Own(const Own&) = delete;
    Own& operator=(const Own&) = delete;
    ~Own();
  };

  std::shared_ptr<Own> own_ = std::make_shared<Own>();
  std::vector<Parameter> defaults_;
  SourceLocation where_;
  ColorSpace color_space_ = ColorSpace::kSrgb;
};

}  // namespace tessera::client::pbrt
