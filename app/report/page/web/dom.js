// An element with attributes and children. Children that are text stay text: nothing here or
// elsewhere in the page is ever parsed as markup.
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
  made.append(...children);
  return made;
}
