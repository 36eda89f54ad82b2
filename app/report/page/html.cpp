// The page as one file: template, style and script are bytes of the program (web.S).

#include <fmt/format.h>
#include <sodium.h>

#include <array>
#include <string_view>

#include "app/report/page/page.hpp"
#include "store/digest.hpp"

extern "C" {
extern const char trammel_page_template[], trammel_page_template_end[];
extern const char trammel_page_style[], trammel_page_style_end[];
extern const char trammel_page_script[], trammel_page_script_end[];
extern const char trammel_page_notices[], trammel_page_notices_end[];
}

namespace trammel::report {

namespace {

/// 'sha256-…' of an element's text, as a policy names it.
std::string source_hash(std::string_view text) {
  const store::Sha256 hash = store::sha256_of(text);
  std::array<char, sodium_base64_ENCODED_LEN(std::tuple_size_v<store::Sha256>,
                                             sodium_base64_VARIANT_ORIGINAL)>
      base64{};
  sodium_bin2base64(base64.data(), base64.size(), hash.data(), hash.size(),
                    sodium_base64_VARIANT_ORIGINAL);
  return fmt::format("'sha256-{}'", base64.data());
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 && c != '\n' ? ' ' : c;
    }
  }
  return out;
}

/// Replaces each @NAME@ once, in the template's order: what is put in is not looked at again.
std::string filled(std::string_view text,
                   const std::vector<std::pair<std::string_view, std::string_view>>& values) {
  std::string out;
  std::size_t at = 0;
  while (at < text.size()) {
    std::size_t next = text.find('@', at);
    if (next == std::string_view::npos) next = text.size();
    out += text.substr(at, next - at);
    at = next;
    if (at == text.size()) break;
    bool known = false;
    for (const auto& [name, value] : values) {
      if (text.substr(at, name.size()) != name) continue;
      out += value;
      at += name.size();
      known = true;
      break;
    }
    if (!known) out += text[at++];
  }
  return out;
}

}  // namespace

std::string script_json(const Json& json) {
  // Text that is no UTF-8 shows replacement characters instead of failing.
  const std::string plain = json.dump(-1, ' ', true, Json::error_handler_t::replace);
  std::string out;
  out.reserve(plain.size());
  for (const char c : plain) {  // ASCII: U+2028 and U+2029 are escaped already
    if (c == '<' || c == '>' || c == '&') {
      out += fmt::format("\\u{:04x}", static_cast<int>(c));
    } else {
      out += c;
    }
  }
  return out;
}

std::string_view page_notices() { return {trammel_page_notices, trammel_page_notices_end}; }

std::string page_html(const Json& page) {
  const std::string_view text(trammel_page_template, trammel_page_template_end);
  const std::string_view style(trammel_page_style, trammel_page_style_end);
  const std::string_view script(trammel_page_script, trammel_page_script_end);
  const std::string policy = fmt::format(
      "default-src 'none'; script-src {}; style-src {}; img-src data:; {}base-uri 'none'; "
      "form-action 'none'",
      source_hash(script), source_hash(style), page.contains("live") ? "connect-src 'self'; " : "");
  const std::string title = escaped("Campaign " + page.at("campaign").get<std::string>());
  const std::string verdict = escaped(page.at("verdict").get<std::string>());
  const std::string banner =
      page.at("kind") == "simulated" ? R"(<div class="simulated">SIMULATED</div>)" : "";
  return filled(text, {{"@CSP@", policy},
                       {"@TITLE@", title},
                       {"@STYLE@", style},
                       {"@BANNER@", banner},
                       {"@VERDICT@", verdict},
                       {"@NOTICES@", escaped(page_notices())},
                       {"@DATA@", script_json(page)},
                       {"@SCRIPT@", script}});
}

}  // namespace trammel::report
