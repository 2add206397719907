// The properties of one object, by name and type.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "import/mitsuba/context.h"

namespace tessera::client::mitsuba {

/// A property of another type than asked for is an error at its place, and the fallback is given. What nobody
/// asked for is a warning once all is read (`warn_of_unused`).
class PropertyReader {
 public:
  PropertyReader(Context& context, Object& object) : context_(context), object_(object) {
    object.is_read = true;
  }

  Context& context() { return context_; }
  Diagnostics& diagnostics() { return context_.diagnostics; }
  const Object& object() const { return object_; }
  /// All of them, in the order of the file; who takes one marks it as used.
  std::vector<Property>& properties() { return object_.properties; }

  /// Null when there is no such property; it counts as used.
  Property* find(std::string_view name);
  bool has(std::string_view name) const;

  double number(std::string_view name, double fallback);
  std::int64_t integer(std::string_view name, std::int64_t fallback);
  bool boolean(std::string_view name, bool fallback);
  std::string text(std::string_view name, const std::string& fallback);
  /// In lower case.
  std::string keyword(std::string_view name, const std::string& fallback);
  /// Where an animation is given, it is where it has things when the shutter opens.
  Imath::M44d transform(std::string_view name);
  /// The placings while the shutter is open, which Context knows; one alone for what stands still.
  std::vector<TimedPlacing> motion(std::string_view name);
  std::optional<Imath::V3d> vector(std::string_view name);

  /// Nested or referenced objects with this tag, in the order of the file.
  std::vector<Property*> children(std::string_view tag);
  /// The only one, null when there is none; more are an error.
  Object* child(std::string_view tag);
  /// The one with this name and tag.
  Object* named_child(std::string_view name, std::string_view tag);

  /// The file that a property names; nothing, with an error, when the property is missing or the file does
  /// not exist.
  std::optional<std::filesystem::path> file(std::string_view name);

  void error(std::string message) { diagnostics().error(object_.where, std::move(message)); }
  void warn(std::string message) { diagnostics().warning(object_.where, std::move(message)); }
  /// `parameter "alpha" of bsdf "roughconductor": ` and what is wrong, at the property's place.
  void error(const Property& property, std::string_view what);

  /// Marks properties that do not change what the image converges to.
  void ignore(std::initializer_list<std::string_view> names);

 private:
  Context& context_;
  Object& object_;
};

/// One warning for each property of the objects that were read which nobody asked for. Objects that nobody
/// read, such as materials of no shape, are not looked at.
void warn_of_unused(Context& context);

}  // namespace tessera::client::mitsuba
