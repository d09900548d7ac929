#include "twin/page.h"

#include <fmt/format.h>

namespace wheel_twin::twin::page {
namespace {

const char style[] = R"(
:root { --ink: #1c2330; --soft: #5b6475; --line: #dfe3ea; --paper: #ffffff; --ground: #f4f6f9; --accent: #0072b2; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink); font: 15px/1.55 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width: 1200px; margin: 0 auto; padding: 32px 28px 64px; background: var(--paper); min-height: 100vh; }
h1 { font-size: 28px; margin: 0; } .subtitle { color: var(--soft); font-size: 17px; margin: 2px 0 18px; }
h2 { font-size: 20px; margin: 36px 0 10px; padding-bottom: 6px; border-bottom: 2px solid var(--accent); }
h3 { font-size: 16px; margin: 22px 0 6px; }
p { max-width: 80ch; } .note { color: var(--soft); font-size: 13px; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: 8px 0; font-variant-numeric: tabular-nums; font-size: 14px; }
th, td { padding: 5px 12px; text-align: right; border-bottom: 1px solid var(--line); vertical-align: top; }
th { color: var(--soft); font-weight: 600; max-width: 16ch; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; }
tbody tr:hover { background: var(--ground); }
.pair { display: grid; grid-template-columns: repeat(auto-fill, minmax(420px, 1fr)); gap: 8px; }
.grid { display: grid; grid-template-columns: repeat(auto-fill, minmax(340px, 1fr)); gap: 8px; }
svg { display: block; width: 100%; max-width: 640px; height: auto; }
details { border: 1px solid var(--line); border-radius: 6px; margin: 6px 0; padding: 6px 12px; }
summary { cursor: pointer; font-variant-numeric: tabular-nums; }
)";

}  // namespace

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string document(const std::string& title, const std::string& html) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\"><title>{}</title><style>{}</style></head>\n"
      "<body><main>\n{}\n</main></body></html>\n",
      escaped(title), style, html);
}

std::string heading(const std::string& title, const std::string& subtitle) {
  return fmt::format("<h1>{}</h1><div class=\"subtitle\">{}</div>\n", escaped(title), escaped(subtitle));
}

std::string paragraph(const std::string& text) {
  return "<p>" + escaped(text) + "</p>\n";
}
std::string note(const std::string& text) {
  return "<p class=\"note\">" + escaped(text) + "</p>\n";
}

std::string row(const std::vector<std::string>& cells) {
  std::string html = "<tr>";
  for (const std::string& cell : cells) html += "<td>" + escaped(cell) + "</td>";
  return html + "</tr>\n";
}

std::string table(const std::vector<std::string>& head, const std::string& rows) {
  std::string html = "<div class=\"scroll\"><table><thead><tr>";
  for (const std::string& cell : head) html += "<th>" + escaped(cell) + "</th>";
  return html + "</tr></thead><tbody>\n" + rows + "</tbody></table></div>\n";
}

std::string folded(const std::string& summary, const std::string& html) {
  return "<details><summary>" + escaped(summary) + "</summary>" + html + "</details>\n";
}

std::string pair(const std::string& left, const std::string& right) {
  if (left.empty() && right.empty()) return {};
  return "<div class=\"pair\">" + left + right + "</div>\n";
}

}  // namespace wheel_twin::twin::page
