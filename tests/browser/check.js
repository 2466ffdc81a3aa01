// SPDX-License-Identifier: MIT
// Runs inside a copy of the page: what does a person with a screen this wide
// see? Tells the frame around it, one line for each thing that is wrong.
const wrong = []
const page = document.documentElement
if (page.scrollWidth > innerWidth)
  wrong.push(`the page is ${page.scrollWidth} wide on ${innerWidth}`)

const charts = [...document.querySelectorAll('svg.chart')]
for (const chart of charts) {
  const name = chart.getAttribute('aria-label')
  const drawn = [...chart.querySelectorAll('circle, rect')].filter(e => e.getBBox().width > 0)
  if (drawn.length === 0)
    wrong.push(`'${name}' has no data`)
  const frame = chart.getBoundingClientRect()
  for (const part of chart.querySelectorAll('circle, rect, path, text, polyline, line')) {
    const box = part.getBoundingClientRect()
    if (box.left < frame.left - 1 || box.right > frame.right + 1 ||
        box.top < frame.top - 1 || box.bottom > frame.bottom + 1)
      wrong.push(`'${name}': ${part.tagName} '${part.textContent}' lies outside`)
  }
}
function overlap(one, other) {
  const a = one.getBoundingClientRect(), b = other.getBoundingClientRect()
  return Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 &&
         Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 4
}
for (const chart of charts) {
  const texts = [...chart.querySelectorAll('text')]
  texts.forEach((text, i) => texts.slice(i + 1).forEach(other => {
    if (overlap(text, other))
      wrong.push(`'${text.textContent}' runs into '${other.textContent}'`)
  }))
}
if (charts.length === 0)
  wrong.push('there is no chart')
const headings = [...document.querySelectorAll('h2')].map(h => h.textContent)
for (const heading of ['Searches', 'Accuracy against time', 'What effects cost', 'Standard set: shares'])
  if (!headings.includes(heading))
    wrong.push(`there is no '${heading}'`)
parent.postMessage(`${innerWidth} wide: ${wrong.length ? wrong.join('; ') : charts.length + ' charts are right'}`, '*')
