// The syntax of pbrt-v4 files: directives, included files, parameter lists.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "import/input/include_stack.h"
#include "import/pbrt/directive_handler.h"
#include "import/pbrt/file/tokenizer.h"

namespace tessera::client::pbrt {

/// Reads files and calls the builder. Errors are recorded and reading goes on behind them.
class DirectiveReader {
 public:
  DirectiveReader(Context& context, DirectiveHandler& builder) : context_(context), builder_(builder) {}

  /// Reads a file and all that it includes. `named_at` is where it is named, for a message when it cannot be
  /// read.
  void read_file(const std::filesystem::path& path, SourceLocation named_at);

 private:
  using Handler = void (DirectiveReader::*)(const Token& directive);
  struct DirectiveSyntax;
  static const DirectiveSyntax* find_syntax(std::string_view name);

  void read_open_file(const std::filesystem::path& path, SourceLocation named_at);
  void read_directives();
  Token peek();
  Token take();

  // Pieces; each reports what is missing and returns false.
  bool read_string(std::string_view what, std::string& value);
  bool read_numbers(std::span<double> values);
  bool read_matrix(Imath::M44d& transform);
  /// The matrix of `directive`; false, with an error, for one that is projective, too.
  bool read_affine(const Token& directive, Imath::M44d& transform);
  std::vector<Parameter> read_parameters();
  bool read_declaration(const Token& token, Parameter& parameter);
  void read_values(Parameter& parameter);
  bool read_value(const Token& token, Parameter& parameter);
  void check_values(Parameter& parameter);
  void fail(const Token& found, std::string_view expected);

  // Directives that are not of the form `Name "type" parameters`.
  void identity(const Token&);
  void translate(const Token&);
  void scale(const Token&);
  void rotate(const Token&);
  void look_at_directive(const Token&);
  void transform(const Token&);
  void concat_transform(const Token&);
  void coordinate_system(const Token&);
  void coord_sys_transform(const Token&);
  void active_transform(const Token&);
  void transform_times(const Token&);
  void world_begin(const Token&);
  void begin_block(const Token&);
  void end_block(const Token&);
  void object_begin(const Token&);
  void object_end(const Token&);
  void csg_end(const Token&);
  void object_instance(const Token&);
  void reverse_orientation(const Token&);
  void color_space(const Token&);
  void attribute(const Token&);
  void option(const Token&);
  void texture(const Token&);
  void named_material(const Token&);
  void medium_interface(const Token&);
  void include(const Token&);
  void import(const Token&);

  Context& context_;
  DirectiveHandler& builder_;
  Tokenizer* tokenizer_ = nullptr;  // reads the current file
  Token lookahead_;
  bool has_lookahead_ = false;
  IncludeStack files_{64};
};

}  // namespace tessera::client::pbrt
