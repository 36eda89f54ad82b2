// An element with attributes and children. Children that are text stay text: nothing here or
// elsewhere in the page is ever parsed as markup.
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
  made.append(...children);
  return made;
}

// A table that scrolls by itself where it is too wide, by keyboard too.
export function tableOf(title, columns, rows) {
  const head = element('tr', {}, ...columns.map((c) => element('th', { scope: 'col' }, c)));
  const body = rows.map((r) => element('tr', {}, ...r.map((cell) => element('td', /\S{30}/.test(cell) ? { class: 'long' } : {}, String(cell ?? '-')))));
  return element('div', { class: 'scroll', role: 'region', tabindex: '0', 'aria-label': title },
    element('table', {}, element('thead', {}, head), element('tbody', {}, ...body)));
}
