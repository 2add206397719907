#include "import/mitsuba/document/document_reader.h"

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <set>

#include "import/input/concat.h"
#include "import/input/include_stack.h"
#include "import/input/input_file.h"
#include "import/mitsuba/document/old_versions.h"
#include "import/mitsuba/document/parameters.h"
#include "import/mitsuba/document/reference_check.h"
#include "import/mitsuba/document/transform_reader.h"
#include "import/mitsuba/document/value_text.h"
#include "import/mitsuba/document/xml_file.h"
#include "wire/scene_numbers.h"

namespace tessera::client::mitsuba {
namespace {

constexpr std::size_t kMaxIncludeDepth = 15;  // the same as Mitsuba's
constexpr int kMaxNesting = 100;              // elements within one another in one file

bool is_object_tag(std::string_view tag) {
  static const std::set<std::string_view> tags = {"scene", "sensor",  "film",       "emitter", "sampler",
                                                  "shape", "texture", "volume",     "medium",  "bsdf",
                                                  "phase", "rfilter", "integrator", "field"};
  return tags.contains(tag);
}

/// State of the file that is being read.
struct FileScope {
  const XmlFile& file;
  std::filesystem::path directory;
  bool before_version_2 = false;
};

class DocumentReader {
 public:
  DocumentReader(const std::map<std::string, std::string>& defines, Diagnostics& diagnostics)
      : diagnostics_(diagnostics), parameters_(defines) {}

  Document read(const std::filesystem::path& path) {
    document_.search_path.push_back(path.parent_path());
    read_file(path, SourceLocation{}, nullptr, "");
    if (!diagnostics_.full()) resolve_references(references_, ids_, document_, diagnostics_);
    for (const std::string& name : parameters_.unused()) {
      diagnostics_.warning({},
                           concat("the scene has no parameter \"", name, "\": its definition has no effect"));
    }
    return std::move(document_);
  }

 private:
  using Node = pugi::xml_node;

  void fail(const FileScope& scope, const Node& node, std::string message) {
    diagnostics_.error(scope.file.locate(node), std::move(message));
  }

  void read_file(const std::filesystem::path& path, SourceLocation included_from, Object* parent,
                 const std::string& name);
  void read_open_file(const std::filesystem::path& path, SourceLocation included_from, Object* parent,
                      const std::string& name);
  void read_element(const FileScope& scope, Node node, Object& parent, int nesting);
  void read_object(const FileScope& scope, Node node, Object* parent, const std::string& name, int nesting);
  void read_children(const FileScope& scope, const Node& node, Object& object, int nesting);
  void read_value(const FileScope& scope, const Node& node, Object& parent);
  void read_include(const FileScope& scope, const Node& node, Object& parent);
  void read_path(const FileScope& scope, const Node& node, const Object& parent);
  void read_alias(const FileScope& scope, const Node& node);
  std::string spectrum_value(const FileScope& scope, const Node& node, Value& value);
  std::string transform_value(const FileScope& scope, const Node& node, Value& value);
  void read_animation(const FileScope& scope, const Node& node, Object& parent);
  bool substitute(const FileScope& scope, Node node);
  bool check_attributes(const FileScope& scope, const Node& node,
                        std::initializer_list<std::string_view> required,
                        std::initializer_list<std::string_view> optional = {});
  void add_property(const FileScope& scope, const Node& node, Object& object, std::string name, Value value);
  std::optional<bool> is_before_version_2(const FileScope& scope, const Node& root);

  Diagnostics& diagnostics_;
  Parameters parameters_;
  IncludeStack files_{kMaxIncludeDepth + 1};
  Document document_;
  std::map<std::string, Object*> ids_;
  std::vector<Reference> references_;
};

bool DocumentReader::substitute(const FileScope& scope, Node node) {
  for (pugi::xml_attribute attribute : node.attributes()) {
    std::string text = attribute.value();
    if (std::string problem = parameters_.substitute(text); !problem.empty()) {
      fail(scope, node, std::move(problem));
      return false;
    }
    attribute.set_value(text.c_str());
  }
  return true;
}

bool DocumentReader::check_attributes(const FileScope& scope, const Node& node,
                                      std::initializer_list<std::string_view> required,
                                      std::initializer_list<std::string_view> optional) {
  const auto contains = [](std::initializer_list<std::string_view> names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    if (contains(required, attribute.name()) || contains(optional, attribute.name())) continue;
    fail(scope, node, concat("<", node.name(), "> has no attribute \"", attribute.name(), "\""));
    return false;
  }
  for (const std::string_view name : required) {
    if (node.attribute(std::string(name).c_str())) continue;
    fail(scope, node, concat("<", node.name(), "> needs the attribute \"", name, "\""));
    return false;
  }
  return true;
}

void DocumentReader::add_property(const FileScope& scope, const Node& node, Object& object, std::string name,
                                  Value value) {
  const bool taken = !name.empty() && std::any_of(object.properties.begin(), object.properties.end(),
                                                  [&](const Property& p) { return p.name == name; });
  if (taken) {
    fail(scope, node, concat("\"", name, "\" of the ", object.title(), " is there twice"));
    return;
  }
  Property property;
  property.name = std::move(name);
  property.value = std::move(value);
  property.where = scope.file.locate(node);
  object.properties.push_back(std::move(property));
}

std::optional<bool> DocumentReader::is_before_version_2(const FileScope& scope, const Node& root) {
  const std::string_view version = root.attribute("version").value();
  if (version.empty()) {
    fail(scope, root, concat("<", root.name(), "> needs the attribute \"version\""));
    return std::nullopt;
  }
  const auto major = parse_integer(version.substr(0, version.find('.')));
  if (!major || *major < 0) {
    fail(scope, root, concat("\"", version, "\" is not a version: expected one like \"3.0.0\""));
    return std::nullopt;
  }
  return *major < 2;
}

void DocumentReader::read_file(const std::filesystem::path& path, SourceLocation included_from,
                               Object* parent, const std::string& name) {
  if (const std::string problem = files_.enter(path); !problem.empty())
    return diagnostics_.error(included_from, problem);
  read_open_file(path, included_from, parent, name);
  files_.leave();
}

void DocumentReader::read_open_file(const std::filesystem::path& path, SourceLocation included_from,
                                    Object* parent, const std::string& name) {
  XmlFile file;
  if (!file.load(path, included_from, diagnostics_)) return;
  if (const std::string problem = files_.count_bytes(file.size()); !problem.empty())
    return diagnostics_.error(included_from, problem);
  FileScope scope{file, path.parent_path(), false};
  const Node root = file.root();
  const std::optional<bool> before_version_2 = is_before_version_2(scope, root);
  if (!before_version_2) return;
  scope.before_version_2 = *before_version_2;
  const bool is_scene = std::string_view(root.name()) == "scene";
  if (parent == nullptr && !is_scene) {
    fail(scope, root, concat("expected <scene> as the outermost element, found <", root.name(), ">"));
  } else if (parent != nullptr && is_scene) {
    read_children(scope, root, *parent, 1);
  } else if (is_object_tag(root.name())) {
    read_object(scope, root, parent, name, 0);
  } else {
    fail(scope, root, concat("<", root.name(), "> cannot be the outermost element of a file"));
  }
}

void DocumentReader::read_children(const FileScope& scope, const Node& node, Object& object, int nesting) {
  for (const Node& child : node.children()) {
    if (diagnostics_.full()) return;
    if (child.type() == pugi::node_element) read_element(scope, child, object, nesting + 1);
  }
}

void DocumentReader::read_element(const FileScope& scope, Node node, Object& parent, int nesting) {
  if (nesting > kMaxNesting) {
    fail(scope, node, concat("elements are nested more than ", kMaxNesting, " deep"));
    return;
  }
  if (!substitute(scope, node)) return;
  const std::string_view tag = node.name();
  if (is_object_tag(tag) || (tag == "spectrum" && node.attribute("type"))) {
    if (tag == "scene") return fail(scope, node, "<scene> cannot stand inside another element");
    return read_object(scope, node, &parent, node.attribute("name").value(), nesting);
  }
  if (tag == "animation") return read_animation(scope, node, parent);
  if (tag != "transform") {
    for (const Node& child : node.children()) {
      if (child.type() != pugi::node_element) continue;
      return fail(scope, child, concat("<", child.name(), "> cannot stand inside <", tag, ">"));
    }
  }
  if (tag == "default") {
    if (!check_attributes(scope, node, {"name", "value"})) return;
    parameters_.add_default(node.attribute("name").value(), node.attribute("value").value());
  } else if (tag == "include") {
    read_include(scope, node, parent);
  } else if (tag == "path") {
    read_path(scope, node, parent);
  } else if (tag == "alias") {
    read_alias(scope, node);
  } else if (tag == "ref") {
    if (!check_attributes(scope, node, {"id"}, {"name"})) return;
    std::string name = node.attribute("name").value();
    if (scope.before_version_2) name = underscore_case(name);
    references_.push_back({&parent, std::move(name), node.attribute("id").value(), scope.file.locate(node)});
    add_property(scope, node, parent, references_.back().name, static_cast<Object*>(nullptr));
  } else {
    read_value(scope, node, parent);
  }
}

void DocumentReader::read_object(const FileScope& scope, Node node, Object* parent, const std::string& name,
                                 int nesting) {
  const bool is_scene = std::string_view(node.name()) == "scene";
  if (!substitute(scope, node)) return;
  if (is_scene ? !check_attributes(scope, node, {}, {"version", "type", "id", "name"})
               : !check_attributes(scope, node, {"type"}, {"id", "name", "version"})) {
    return;
  }
  Object& object = document_.objects.emplace_back();
  object.tag = std::string_view(node.name()) == "spectrum" ? "texture" : node.name();
  object.type = is_scene ? "scene" : node.attribute("type").value();
  object.id = node.attribute("id").value();
  object.where = scope.file.locate(node);
  if (!object.id.empty() && !ids_.try_emplace(object.id, &object).second) {
    const Object& other = *ids_[object.id];
    const Diagnostic place = {diagnostics_.file_name(other.where.file), other.where.line, other.where.column,
                              ""};
    fail(scope, node,
         concat("the id \"", object.id, "\" is taken: it was given at ", place.file, ":", place.line));
  }
  if (parent == nullptr) {
    document_.root = &object;
  } else {
    add_property(scope, node, *parent, scope.before_version_2 ? underscore_case(name) : name, &object);
  }
  read_children(scope, node, object, nesting);
  if (scope.before_version_2) upgrade_from_version_1(object);
}

void DocumentReader::read_include(const FileScope& scope, const Node& node, Object& parent) {
  if (!check_attributes(scope, node, {"filename"}, {"name"})) return;
  const std::string file = node.attribute("filename").value();
  std::filesystem::path path = scope.directory / file;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) path = document_.resolve(file);
  if (!std::filesystem::is_regular_file(path, error)) {
    return fail(scope, node, concat("there is no file \"", file, "\" to include"));
  }
  // Files that an included file names may also lie beside it.
  const std::filesystem::path folder = path.parent_path();
  auto& folders = document_.search_path;
  if (std::find(folders.begin(), folders.end(), folder) == folders.end()) folders.push_back(folder);
  read_file(path, scope.file.locate(node), &parent, node.attribute("name").value());
}

void DocumentReader::read_path(const FileScope& scope, const Node& node, const Object& parent) {
  if (!check_attributes(scope, node, {"value"})) return;
  if (parent.tag != "scene") return fail(scope, node, "<path> can only stand directly inside <scene>");
  const std::string folder = node.attribute("value").value();
  std::filesystem::path path = scope.directory / folder;
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) path = document_.resolve(folder);
  if (!std::filesystem::is_directory(path, error)) {
    return fail(scope, node, concat("there is no folder \"", folder, "\""));
  }
  document_.search_path.insert(document_.search_path.begin(), path);
}

void DocumentReader::read_alias(const FileScope& scope, const Node& node) {
  if (!check_attributes(scope, node, {"id", "as"})) return;
  const std::string id = node.attribute("id").value(), as = node.attribute("as").value();
  const auto known = ids_.find(id);
  if (known == ids_.end())
    return fail(scope, node, concat("there is no object with the id \"", id, "\" yet"));
  if (!ids_.try_emplace(as, known->second).second) fail(scope, node, concat("the id \"", as, "\" is taken"));
}

std::string DocumentReader::spectrum_value(const FileScope& scope, const Node& node, Value& value) {
  const std::string text = node.attribute("value").value(), file = node.attribute("filename").value();
  if (text.empty() == file.empty()) return "<spectrum> needs either \"value\" or \"filename\"";
  SpectrumData spectrum;
  std::string problem;
  if (!text.empty()) {
    problem = parse_spectrum(text, spectrum);
  } else {
    std::filesystem::path path = scope.directory / file;
    std::error_code error;
    if (!std::filesystem::exists(path, error)) path = document_.resolve(file);
    absl::StatusOr<InputFile> input = InputFile::open(path);
    if (!input.ok()) return std::string(input.status().message());
    problem = parse_spectrum_file(input->bytes(), spectrum);
    if (!problem.empty()) problem = concat(path.string(), ": ", problem);
  }
  value = std::move(spectrum);
  return problem;
}

std::string DocumentReader::transform_value(const FileScope& scope, const Node& node, Value& value) {
  Imath::M44d transform;
  for (const Node& operation : node.children()) {
    if (operation.type() != pugi::node_element) continue;
    if (!substitute(scope, operation)) continue;
    if (std::string problem = apply_operation(operation, transform); !problem.empty())
      fail(scope, operation, problem);
  }
  value = transform;
  return is_finite(transform) ? "" : "the transformation is not finite";
}

/// Transforms at times, as before version 2.
void DocumentReader::read_animation(const FileScope& scope, const Node& node, Object& parent) {
  if (!check_attributes(scope, node, {"name"})) return;
  Animation animation;
  for (const Node& key : node.children()) {
    if (key.type() != pugi::node_element) continue;
    if (std::string_view(key.name()) != "transform") {
      fail(scope, key, concat("<", key.name(), "> cannot stand inside <animation>: expected <transform>"));
      continue;
    }
    if (!substitute(scope, key) || !check_attributes(scope, key, {"time"}, {"name"})) continue;
    const std::string text = key.attribute("time").value();
    const std::optional<double> time = parse_float(text);
    Value placing;
    if (!time) {
      fail(scope, key, concat("expected ", wire::kSceneNumberRange, " as \"time\", found \"", text, "\""));
    } else if (!animation.keys.empty() && !(*time > animation.keys.back().time)) {
      fail(scope, key, concat("the time ", text, " is not after that of the transform before"));
    }
    if (const std::string problem = transform_value(scope, key, placing); !problem.empty())
      fail(scope, key, problem);
    if (time) animation.keys.push_back({*time, std::get<Imath::M44d>(placing)});
  }
  if (animation.keys.empty()) return fail(scope, node, "an <animation> has a <transform> at least");
  add_property(scope, node, parent, node.attribute("name").value(), std::move(animation));
}

void DocumentReader::read_value(const FileScope& scope, const Node& node, Object& parent) {
  const std::string_view tag = node.name();
  const std::string text = node.attribute("value").value();
  const bool is_vector = tag == "point" || tag == "vector";
  static const std::set<std::string_view> plain = {"boolean", "integer", "float", "string", "rgb"};
  if (!is_vector && tag != "spectrum" && tag != "transform" && !plain.contains(tag)) {
    return fail(scope, node, concat("<", tag, "> is not an element of the scene language"));
  }
  const bool attributes_fit = is_vector ? check_attributes(scope, node, {"name"}, {"x", "y", "z", "value"})
                              : tag == "spectrum"
                                  ? check_attributes(scope, node, {"name"}, {"value", "filename"})
                              : tag == "transform" ? check_attributes(scope, node, {"name"})
                                                   : check_attributes(scope, node, {"name", "value"});
  if (!attributes_fit) return;

  Value value;
  std::string problem;
  const auto expect = [&](auto parsed, std::string_view what) {
    if (parsed) {
      value = *parsed;
    } else {
      problem = concat("expected ", what, ", found \"", text, "\"");
    }
  };
  if (tag == "boolean") {
    expect(parse_boolean(text), "true or false");
  } else if (tag == "integer") {
    expect(parse_integer(text), "an integer");
  } else if (tag == "float") {
    expect(parse_float(text), wire::kSceneNumberRange);
  } else if (tag == "string") {
    value = String{text};
  } else if (tag == "rgb") {
    const auto numbers = parse_floats(text);
    if (numbers && (numbers->size() == 1 || numbers->size() == 3)) {
      const bool three = numbers->size() == 3;
      value = Rgb{{(*numbers)[0], (*numbers)[three ? 1 : 0], (*numbers)[three ? 2 : 0]}};
    } else {
      problem = concat("expected one or three numbers, found \"", text, "\"");
    }
  } else if (is_vector) {
    Imath::V3d vector;
    problem = read_vector(node, 0, vector);
    value = vector;
  } else if (tag == "spectrum") {
    problem = spectrum_value(scope, node, value);
  } else {
    problem = transform_value(scope, node, value);
  }
  if (!problem.empty()) return fail(scope, node, problem);
  add_property(scope, node, parent, node.attribute("name").value(), std::move(value));
}

}  // namespace

std::string Object::title() const { return type == "scene" ? "scene" : concat(tag, " \"", type, "\""); }

std::filesystem::path Document::resolve(const std::string& file) const {
  const std::filesystem::path path(file);
  if (path.is_absolute()) return path;
  std::error_code error;
  for (const std::filesystem::path& folder : search_path) {
    if (std::filesystem::exists(folder / path, error)) return folder / path;
  }
  return search_path.empty() ? path : search_path.back() / path;
}

Document read_document(const std::filesystem::path& path, const std::map<std::string, std::string>& defines,
                       Diagnostics& diagnostics) {
  return DocumentReader(defines, diagnostics).read(path);
}

}  // namespace tessera::client::mitsuba
