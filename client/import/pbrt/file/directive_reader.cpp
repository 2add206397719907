#include "import/pbrt/file/directive_reader.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "wire/scene_numbers.h"

namespace tessera::client::pbrt {

/// A directive is read by a handler, or has the form `Name "type" parameters`.
struct DirectiveReader::DirectiveSyntax {
  std::string_view name;
  Handler handler = nullptr;
  DirectiveHandler::Typed typed = nullptr;
};

const DirectiveReader::DirectiveSyntax* DirectiveReader::find_syntax(std::string_view name) {
  using R = DirectiveReader;
  using B = DirectiveHandler;
  // Sorted by name.
  static constexpr DirectiveSyntax kSyntax[] = {
      {"Accelerator", nullptr, &B::accelerator},
      {"ActiveTransform", &R::active_transform},
      {"AreaLightSource", nullptr, &B::area_light_source},
      {"Attribute", &R::attribute},
      {"AttributeBegin", &R::begin_block},
      {"AttributeEnd", &R::end_block},
      {"CSGBegin", nullptr, &B::csg_begin},
      {"CSGEnd", &R::csg_end},
      {"Camera", nullptr, &B::camera},
      {"ColorSpace", &R::color_space},
      {"ConcatTransform", &R::concat_transform},
      {"CoordSysTransform", &R::coord_sys_transform},
      {"CoordinateSystem", &R::coordinate_system},
      {"Film", nullptr, &B::film},
      {"Identity", &R::identity},
      {"Import", &R::import},
      {"Include", &R::include},
      {"Integrator", nullptr, &B::integrator},
      {"LightSource", nullptr, &B::light_source},
      {"LookAt", &R::look_at_directive},
      {"MakeNamedMaterial", nullptr, &B::make_named_material},
      {"MakeNamedMedium", nullptr, &B::make_named_medium},
      {"Material", nullptr, &B::material},
      {"MediumInterface", &R::medium_interface},
      {"NamedMaterial", &R::named_material},
      {"ObjectBegin", &R::object_begin},
      {"ObjectEnd", &R::object_end},
      {"ObjectInstance", &R::object_instance},
      {"Option", &R::option},
      {"PixelFilter", nullptr, &B::pixel_filter},
      {"ReverseOrientation", &R::reverse_orientation},
      {"Rotate", &R::rotate},
      {"Sampler", nullptr, &B::sampler},
      {"Scale", &R::scale},
      {"Shape", nullptr, &B::shape},
      {"Texture", &R::texture},
      {"Transform", &R::transform},
      {"TransformBegin", &R::begin_block},
      {"TransformEnd", &R::end_block},
      {"TransformTimes", &R::transform_times},
      {"Translate", &R::translate},
      {"WorldBegin", &R::world_begin},
  };
  const auto found =
      std::lower_bound(std::begin(kSyntax), std::end(kSyntax), name,
                       [](const DirectiveSyntax& s, std::string_view n) { return s.name < n; });
  return found != std::end(kSyntax) && found->name == name ? &*found : nullptr;
}

// ---------------------------------------------------------------- files and tokens

void DirectiveReader::read_file(const std::filesystem::path& path, SourceLocation named_at) {
  if (const std::string problem = files_.enter(path); !problem.empty()) {
    context_.diagnostics.error(named_at, problem);
    return;
  }
  read_open_file(path, named_at);
  files_.leave();
}

void DirectiveReader::read_open_file(const std::filesystem::path& path, SourceLocation named_at) {
  Diagnostics& diagnostics = context_.diagnostics;
  absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) {
    diagnostics.error(named_at, std::string(file.status().message()));
    return;
  }
  if (const std::string problem = files_.count_bytes(file->bytes().size()); !problem.empty()) {
    diagnostics.error(named_at, problem);
    return;
  }
  Tokenizer tokenizer(file->bytes(), diagnostics.add_file(path.string()));
  Tokenizer* const outer = std::exchange(tokenizer_, &tokenizer);
  const bool outer_lookahead = std::exchange(has_lookahead_, false);
  const Token outer_token = lookahead_;
  read_directives();
  tokenizer_ = outer;
  has_lookahead_ = outer_lookahead;
  lookahead_ = outer_token;
}

Token DirectiveReader::peek() {
  if (!has_lookahead_) {
    lookahead_ = tokenizer_->next();
    has_lookahead_ = true;
  }
  return lookahead_;
}

Token DirectiveReader::take() {
  const Token token = peek();
  has_lookahead_ = false;
  return token;
}

void DirectiveReader::fail(const Token& found, std::string_view expected) {
  std::string what;
  switch (found.kind) {
    case TokenKind::kProblem:
      what = found.text;
      break;
    case TokenKind::kEnd:
      what = "the end of the file";
      break;
    case TokenKind::kString:
      what = concat("the string \"", found.text, "\"");
      break;
    default:
      what = concat("\"", found.text, "\"");
      break;
  }
  context_.diagnostics.error(found.where, concat("expected ", expected, ", found ", what));
}

void DirectiveReader::read_directives() {
  // After an error, everything up to the next known directive is passed over.
  bool recovering = false;
  while (!context_.diagnostics.full()) {
    const Token token = take();
    if (token.kind == TokenKind::kEnd) return;
    const DirectiveSyntax* syntax = token.kind == TokenKind::kWord ? find_syntax(token.text) : nullptr;
    if (syntax == nullptr) {
      if (!recovering && token.kind == TokenKind::kWord) {
        context_.diagnostics.error(token.where, concat("unknown directive \"", token.text, "\""));
      } else if (!recovering) {
        fail(token, "a directive");
      }
      recovering = true;
      continue;
    }
    recovering = false;
    if (syntax->handler != nullptr) {
      (this->*syntax->handler)(token);
      continue;
    }
    std::string type;
    if (read_string(concat("the type or name of ", token.text), type)) {
      (builder_.*syntax->typed)(type, read_parameters(), token.where);
    } else {
      recovering = true;
    }
  }
}

bool DirectiveReader::read_string(std::string_view what, std::string& value) {
  const Token token = peek();
  if (token.kind != TokenKind::kString) {
    fail(token, concat(what, " in quotes"));
    return false;
  }
  take();
  std::optional<std::string> text = unescape(token.text);
  if (!text) fail(token, "a string without unknown escapes");
  value = std::move(text).value_or("");
  return true;
}

bool DirectiveReader::read_numbers(std::span<double> values) {
  for (double& value : values) {
    const Token token = peek();
    const std::optional<double> number =
        token.kind == TokenKind::kWord ? parse_number(token.text) : std::nullopt;
    if (!number) {
      fail(token, wire::kSceneNumberRange);
      return false;
    }
    take();
    value = *number;
  }
  return true;
}

bool DirectiveReader::read_matrix(Imath::M44d& transform) {
  const bool bracketed = peek().kind == TokenKind::kOpen;
  if (bracketed) take();
  double columns[16];
  if (!read_numbers(columns)) return false;
  if (bracketed) {
    if (peek().kind != TokenKind::kClose) {
      fail(peek(), "\"]\" after 16 numbers");
      return false;
    }
    take();
  }
  std::copy_n(columns, 16, transform.getValue());
  return true;
}

// ---------------------------------------------------------------- directives

void DirectiveReader::identity(const Token&) { builder_.set_transform(Imath::M44d{}); }

void DirectiveReader::translate(const Token&) {
  double v[3];
  if (read_numbers(v)) builder_.concatenate(translation(v[0], v[1], v[2]));
}

void DirectiveReader::scale(const Token&) {
  double v[3];
  if (read_numbers(v)) builder_.concatenate(scaling(v[0], v[1], v[2]));
}

void DirectiveReader::rotate(const Token& directive) {
  double v[4];
  if (!read_numbers(v)) return;
  if (v[1] == 0 && v[2] == 0 && v[3] == 0) {
    context_.diagnostics.error(directive.where, "Rotate: the axis has no direction");
    return;
  }
  builder_.concatenate(rotation(v[0], {v[1], v[2], v[3]}));
}

void DirectiveReader::look_at_directive(const Token& directive) {
  double v[9];
  if (!read_numbers(v)) return;
  if (const std::optional<Imath::M44d> t =
          look_at({v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8]})) {
    builder_.concatenate(*t);
  } else {
    context_.diagnostics.error(directive.where,
                               "LookAt: the direction of view is zero, or \"up\" lies along it");
  }
}

void DirectiveReader::transform(const Token& directive) {
  Imath::M44d t;
  if (read_affine(directive, t)) builder_.set_transform(t);
}

void DirectiveReader::concat_transform(const Token& directive) {
  Imath::M44d t;
  if (read_affine(directive, t)) builder_.concatenate(t);
}

bool DirectiveReader::read_affine(const Token& directive, Imath::M44d& t) {
  if (!read_matrix(t)) return false;
  if (t[0][3] == 0 && t[1][3] == 0 && t[2][3] == 0 && t[3][3] != 0) return true;
  context_.diagnostics.error(
      directive.where,
      concat(directive.text,
             ": the matrix is projective: its 4th, 8th and 12th number must be 0, and its 16th must not"));
  return false;
}

void DirectiveReader::coordinate_system(const Token&) {
  std::string name;
  if (read_string("a name", name)) builder_.name_coordinate_system(name);
}

void DirectiveReader::coord_sys_transform(const Token& directive) {
  std::string name;
  if (read_string("a name", name)) builder_.use_coordinate_system(name, directive.where);
}

void DirectiveReader::active_transform(const Token&) {
  const Token which = take();
  builder_.set_active_transform(which.text, which.where);
}

void DirectiveReader::transform_times(const Token& directive) {
  double times[2];
  if (read_numbers(times)) builder_.set_transform_times(times[0], times[1], directive.where);
}

void DirectiveReader::world_begin(const Token& directive) { builder_.world_begin(directive.where); }
void DirectiveReader::begin_block(const Token& directive) {
  builder_.begin_block(directive.text, directive.where);
}
void DirectiveReader::end_block(const Token& directive) {
  builder_.end_block(directive.text, directive.where);
}
void DirectiveReader::object_end(const Token& directive) { builder_.object_end(directive.where); }
void DirectiveReader::csg_end(const Token& directive) { builder_.csg_end(directive.where); }
void DirectiveReader::reverse_orientation(const Token&) { builder_.reverse_orientation(); }

void DirectiveReader::object_begin(const Token& directive) {
  std::string name;
  if (read_string("a name", name)) builder_.object_begin(name, directive.where);
}

void DirectiveReader::object_instance(const Token& directive) {
  std::string name;
  if (read_string("a name", name)) builder_.object_instance(name, directive.where);
}

void DirectiveReader::color_space(const Token& directive) {
  std::string name;
  if (read_string("a colour space", name)) builder_.set_color_space(name, directive.where);
}

void DirectiveReader::attribute(const Token& directive) {
  std::string target;
  if (read_string("a target", target)) builder_.set_attributes(target, read_parameters(), directive.where);
}

void DirectiveReader::option(const Token& directive) {
  std::string name;
  if (!read_string("an option", name)) return;
  const Token value = take();
  if (value.kind != TokenKind::kWord && value.kind != TokenKind::kString) {
    fail(value, "the option's value");
    return;
  }
  builder_.option(name, value.text, directive.where);
}

void DirectiveReader::texture(const Token& directive) {
  std::string name, value_type, type;
  if (!read_string("a name", name) || !read_string("\"float\" or \"spectrum\"", value_type) ||
      !read_string("a texture type", type)) {
    return;
  }
  builder_.texture(name, value_type, type, read_parameters(), directive.where);
}

void DirectiveReader::named_material(const Token&) {
  std::string name;
  if (read_string("a name", name)) builder_.named_material(name);
}

void DirectiveReader::medium_interface(const Token& directive) {
  std::string inside, outside;
  if (!read_string("a medium", inside)) return;
  outside = inside;
  if (peek().kind == TokenKind::kString) read_string("a medium", outside);
  builder_.medium_interface(inside, outside, directive.where);
}

void DirectiveReader::include(const Token& directive) {
  std::string file;
  if (read_string("a file", file)) read_file(context_.resolve(file), directive.where);
}

void DirectiveReader::import(const Token& directive) {
  std::string file;
  if (!read_string("a file", file)) return;
  if (!builder_.in_world()) {
    context_.diagnostics.error(directive.where, "Import is only allowed after WorldBegin");
    return;
  }
  GraphicsState before = builder_.state();
  read_file(context_.resolve(file), directive.where);
  builder_.restore(std::move(before));
}

}  // namespace tessera::client::pbrt
