// The 3-D library states sizes as text, products like "width * dpr / 16" or a pair of them in [],
// and would make functions of them by eval, which the page's policy forbids. This does the same.
function product(text, names) {
  let value = 1, divide = false;
  for (const token of text.match(/[\w.]+|[*/]/g)) {
    if (token === '*' || token === '/') divide = token === '/';
    else value *= (names[token] ?? Number(token)) ** (divide ? -1 : 1);
  }
  return value;
}

export function products(text) {
  const pair = /^\s*\[(.*),(.*)\]\s*$/.exec(text);
  return (width, height, dpr = 1) => {
    const names = { width, height, dpr };
    return pair ? [product(pair[1], names), product(pair[2], names)] : product(text, names);
  };
}
